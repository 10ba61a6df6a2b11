//! Where and by what a figure was made; every figure and table carries it.

use serde::Serialize;

use crate::film::source::DeviceInfo;

#[derive(Clone, Debug, Default, Serialize)]
pub struct Provenance {
    pub program: String,
    pub command: String,
    /// What is checked out, when the program runs, where it lies; empty outside of a checkout. Build before measuring.
    pub commit: String,
    /// Processor and number of threads.
    pub machine: String,
    /// UTC.
    pub date: String,
}

/// Characters of a line of `lines`.
const LINE: usize = 150;

impl Provenance {
    /// Of this process.
    pub fn here() -> Self {
        let model = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model =
            model.lines().find_map(|l| l.strip_prefix("model name")).map(|l| l.trim_start_matches([' ', '\t', ':']));
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
        Self {
            program: concat!("steradian ", env!("CARGO_PKG_VERSION")).into(),
            command: command_line(),
            commit: commit().unwrap_or_else(|| "unknown".into()),
            machine: format!("{}, {threads} threads", model.unwrap_or("unknown processor")),
            date: humantime::format_rfc3339_seconds(std::time::SystemTime::now()).to_string(),
        }
    }

    /// What stands below a figure, in lines that fit: command, commit, machine, device, driver, seeds, and the table beside it.
    pub fn lines(&self, device: &DeviceInfo, seeds: &str, table: &str) -> Vec<String> {
        let made = format!(
            "{} {}, {}; {}; {}, {}; seeds {seeds}; data in {table}",
            self.program, self.commit, self.date, self.machine, device.name, device.driver
        );
        [wrapped(&self.command, " "), wrapped(&made, "; ")].concat()
    }

    /// The same as a paragraph of Markdown.
    pub fn markdown(&self, device: &DeviceInfo, seeds: &str, table: &str) -> String {
        format!(
            "Made by `{}`: {}, commit {}, {}; {}; {}, driver {}; seeds {seeds}; data in [{table}]({table}).\n",
            self.command, self.program, self.commit, self.date, self.machine, device.name, device.driver
        )
    }
}

/// Broken where `between` stands, so that what belongs together is found in one line.
fn wrapped(text: &str, between: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for part in text.split(between) {
        let last = lines.last_mut().expect("begun with one");
        if !last.is_empty() && last.len() + between.len() + part.len() > LINE {
            lines.push(part.to_owned());
        } else {
            if !last.is_empty() {
                last.push_str(between);
            }
            last.push_str(part);
        }
    }
    lines
}

/// As one runs it again: `./x` and the arguments.
fn command_line() -> String {
    let mut words: Vec<String> = std::env::args().collect();
    if let Some(first) = words.first_mut() {
        *first = "./x".into();
    }
    words.join(" ")
}

/// Of the checkout that the program lies in, "-dirty" where what renders differs from it: tables and pages in the making do not count.
fn commit() -> Option<String> {
    let name = git(&["describe", "--always"])?;
    let changed =
        git(&["status", "--porcelain", "--", ":/src", ":/shaders", ":/scenes", ":/Cargo.toml", ":/Cargo.lock"])?;
    Some(if changed.is_empty() { name } else { name + "-dirty" })
}

fn git(arguments: &[&str]) -> Option<String> {
    let folder = std::env::current_exe().ok()?.parent()?.to_owned();
    let git = std::process::Command::new("git").arg("-C").arg(folder).args(arguments).output().ok()?;
    git.status.success().then(|| String::from_utf8_lossy(&git.stdout).trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_broken_between_words() {
        let text = ["word"; 100].join(" ");
        let lines = wrapped(&text, " ");
        assert!(lines.len() == 4 && lines.iter().all(|l| l.len() <= LINE), "{lines:?}");
        assert_eq!(lines.join(" "), text);
    }
}
