//! Parts come back as they were; files that are cut, changed or lie are refused with a sentence; merging says what does not fit.

use super::*;
use crate::film::noise::{bits, film};

const WINDOW: Tile = Tile { x: 1, y: 0, width: 5, height: 4 };

fn header(seed: u32) -> Header {
    let identity = Identity {
        program: "steradian".into(),
        device_family: "cpu".into(),
        settings: vec![("--seed".into(), seed.to_string()), ("--aov".into(), "albedo,object".into())],
        scene: "f00".into(),
    };
    let record = Record {
        width: 6,
        height: 4,
        relmse_est_trimmed: Some(f64::INFINITY),
        kernel_hash: "k".into(),
        wall_s: 2.0,
        ..Record::default()
    };
    Header {
        identity,
        window: WINDOW,
        first_block: 0,
        wanted_blocks: Some(8),
        look: Look { exposure_ev: 0.1, ..Look::default() },
        names: Names::default(),
        record,
    }
}

/// A part of blocks in a folder.
fn part(folder: &Path, name: &str, blocks: std::ops::Range<u64>, header: &Header) -> PathBuf {
    let mut film = film(WINDOW, header.aovs().unwrap(), blocks);
    film.set_names(Names { objects: vec!["Stuhl \"é\"".into()], ..Names::default() });
    let path = folder.join(name);
    write(&path, header, &film).unwrap();
    path
}

#[test]
fn a_part_comes_back() {
    let dir = tempfile::tempdir().unwrap();
    let path = part(dir.path(), "a.part", 2..5, &header(1));
    let back = read(&path).unwrap();
    let made = film(WINDOW, back.header.aovs().unwrap(), 2..5);
    assert_eq!(bits(&back.film), bits(&made));
    assert_eq!((back.film.ray_count(), back.film.ledger()), (made.ray_count(), made.ledger()));
    assert_eq!(back.film.names().objects, ["Stuhl \"é\""]);
    assert_eq!((back.header.first_block, back.header.look, back.header.record.spp), (2, header(1).look, 48));
    assert_eq!(back.header.record.relmse_est_trimmed, None, "infinity is no JSON");
    assert_eq!(read_header(&path).unwrap(), back.header);
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1, "nothing is left beside");
}

/// As many rows of a slot as the scene has light groups.
#[test]
fn light_groups_come_back() {
    let dir = tempfile::tempdir().unwrap();
    let mut header = header(1);
    header.identity.settings[1].1 = "albedo,light_groups".into();
    header.names.groups = ["lamp", "sky", ""].map(String::from).to_vec();
    let aovs = header.aovs().unwrap();
    assert_eq!(aovs.group_count(), 3);
    let mut made = film(WINDOW, aovs, 0..2);
    made.set_names(header.names.clone());
    let path = dir.path().join("a.part");
    write(&path, &header, &made).unwrap();
    let back = read(&path).unwrap();
    assert_eq!((bits(&back.film), back.film.aovs()), (bits(&made), aovs));
    header.names.groups = vec!["x".into(); 99];
    assert_eq!(header.aovs(), None, "more than slots hold");
}

#[test]
fn any_cut_and_any_changed_byte_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = part(dir.path(), "a.part", 0..2, &header(1));
    let whole = std::fs::read(&path).unwrap();
    let refused = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        let error = read(&path).unwrap_err().to_string();
        assert!(error.contains("a.part: ") && !error.contains('\n'), "{error}");
        error
    };
    for length in (0..whole.len()).step_by(7).chain(whole.len() - 20..whole.len()) {
        refused(&whole[..length]);
    }
    for at in (0..whole.len()).step_by(11).chain(0..32) {
        let mut changed = whole.clone();
        changed[at] ^= 1 << (at % 8);
        let error = refused(&changed);
        assert!(at < 16 || error.contains("damaged or cut short"), "{at}: {error}");
    }
    assert!(refused(&[&whole[..], b"more"].concat()).contains("damaged"));
    assert!(refused(b"").contains("too short"));
    assert!(refused(&[b'x'; 100]).contains("not a part file"));
}

/// The checksum is right, and the content is not: nothing is believed.
#[test]
fn a_lying_header_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = part(dir.path(), "a.part", 0..2, &header(1));
    let whole = std::fs::read(&path).unwrap();
    let length = u64::from_le_bytes(whole[16..24].try_into().unwrap()) as usize;
    let sealed = |json: &str| {
        let mut out = Seal::new(Vec::new());
        out.write_all(&whole[..16]).unwrap();
        out.write_all(&(json.len() as u64).to_le_bytes()).unwrap();
        out.write_all(json.as_bytes()).unwrap();
        out.write_all(&whole[24 + length..whole.len() - 16]).unwrap();
        let (sum, mut bytes) = out.finish();
        bytes.extend(sum.to_le_bytes());
        std::fs::write(&path, bytes).unwrap();
        read(&path)
    };
    let honest = std::str::from_utf8(&whole[24..24 + length]).unwrap();
    assert!(sealed(honest).is_ok());
    for (from, to, word) in [
        ("\"width\":5", "\"width\":50000", "window"),
        ("\"width\":6,\"height\":4", "\"width\":65536,\"height\":65536", ""),
        ("\"first_block\":0", "\"first_block\":99999999999", "2^32"),
        ("\"wanted_blocks\":8", "\"wanted_blocks\":99999999999", "2^32"),
        ("albedo,object", "albedo,subject", "AOVs"),
        ("albedo,object", "albedo,normal,object", "lists of ids"),
        ("\"nan\":", "\"nan\":9999999999999999", "counts"),
        ("{", "", "header"),
    ] {
        assert!(honest.contains(from), "{from}");
        match sealed(&honest.replacen(from, to, 1)) {
            Err(e) => assert!(e.to_string().contains(word) && !word.is_empty(), "{from} to {to}: {e}"),
            Ok(_) => assert_eq!(word, "", "{to}"),
        }
    }
    let window = "\"x\":1,\"y\":0,\"width\":5,\"height\":4";
    let huge = honest.replacen(window, "\"x\":0,\"y\":0,\"width\":65536,\"height\":65536", 1);
    let huge = huge.replace("\"width\":6,\"height\":4", "\"width\":65536,\"height\":65536");
    let said = sealed(&huge).unwrap_err().to_string();
    assert!(said.contains("a.part") && said.contains("more than its bytes"), "{said}");
}

#[test]
fn merging_adds_in_order_and_refuses_what_does_not_fit() {
    let dir = tempfile::tempdir().unwrap();
    let make = |name: &str, blocks, header: &Header| part(dir.path(), name, blocks, header);
    let (a, b, c) = (make("a", 0..3, &header(1)), make("b", 3..4, &header(1)), make("c", 4..9, &header(1)));
    let whole = merge(&[c.clone(), a.clone(), b.clone()]).unwrap();
    let one = film(WINDOW, whole.header.aovs().unwrap(), 0..9);
    assert_eq!(whole.film.mean_f32(), one.mean_f32());
    assert_eq!((whole.film.ray_count(), whole.header.record.wall_s), (one.ray_count(), 6.0));
    assert_eq!(whole.header.wanted_blocks, Some(4 + 8));
    assert!(merge(std::slice::from_ref(&c)).is_ok(), "one part alone is a merge");
    let refused = |paths: &[&PathBuf], words: &[&str]| {
        let paths: Vec<PathBuf> = paths.iter().map(|p| p.to_path_buf()).collect();
        let error = merge(&paths).unwrap_err().to_string();
        words.iter().for_each(|word| assert!(error.contains(word), "{word}: {error}"));
    };
    refused(&[&a, &c], &["samples 48..64 are missing between", "/a and it"]);
    refused(&[&a, &a], &["samples 0..48 overlap", "/a, 0..48"]);
    let other_seed = make("d", 3..4, &header(2));
    refused(&[&a, &other_seed], &["/d: its --seed is 2", "/a is 1"]);
    let change = |change: &dyn Fn(&mut Header)| {
        let mut changed = header(1);
        change(&mut changed);
        make("d", 3..4, &changed)
    };
    refused(&[&a, &change(&|h| h.identity.scene = "f01".into())], &["/d: its scene", "not that of"]);
    refused(&[&a, &change(&|h| h.identity.program = "steradian 9".into())], &["its version is steradian 9"]);
    refused(&[&a, &change(&|h| h.identity.device_family = "gpu X".into())], &["its device is gpu X", "is cpu"]);
    let mut placed = Film::over(WINDOW, whole.header.aovs().unwrap(), 0);
    placed.set_names(whole.film.names().clone());
    placed.begin_adaptive();
    let placed_path = dir.path().join("placed");
    write(&placed_path, &header(1), &placed).unwrap();
    refused(&[&a, &placed_path], &["placed by what they showed"]);
    let kernel = merge(&[a, change(&|h| h.record.kernel_hash = "l".into())]).unwrap();
    assert!(kernel.header.record.notes[0].contains("kernel k and kernel l"), "{:?}", kernel.header.record.notes);
}

/// Pixels that differ in samples are welcome at the end, and nowhere before it.
#[test]
fn an_interrupted_part_is_merged_only_as_the_last() {
    let dir = tempfile::tempdir().unwrap();
    let header = header(1);
    let aovs = header.aovs().unwrap();
    let mut torn = film(WINDOW, aovs, 2..4);
    torn.add_film(&film(Tile { height: 1, ..WINDOW }, aovs, 4..5));
    let torn_path = dir.path().join("torn");
    let before = part(dir.path(), "before", 0..2, &header);
    let after = part(dir.path(), "after", 5..6, &header);
    let names = Names { objects: vec!["Stuhl \"é\"".into()], ..Names::default() };
    torn.set_names(names);
    write(&torn_path, &header, &torn).unwrap();
    let whole = merge(&[before.clone(), torn_path.clone()]).unwrap();
    assert_eq!((whole.film.min_block_count(), whole.film.max_block_count()), (4, 5));
    let error = merge(&[before, torn_path, after]).unwrap_err().to_string();
    assert!(error.contains("some pixels end at sample 64, others at 80") && error.contains("--resume"), "{error}");
}

#[test]
fn what_a_killed_writer_left_is_swept() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.part");
    // No process has this number: the kernel's largest is 2^22.
    let (dead, alive) = (dir.path().join(".a.part.4999999.tmp"), dir.path().join(".a.part.1.tmp"));
    let other = dir.path().join(".b.part.4999999.tmp");
    for file in [&dead, &alive, &other] {
        std::fs::write(file, b"half a film").unwrap();
    }
    crate::output::check(&path).unwrap();
    let swept = Path::new("/proc/self").exists();
    assert_eq!((dead.exists(), alive.exists(), other.exists()), (!swept, true, true));
}
