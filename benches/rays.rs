//! `cargo bench --bench rays [-- DEVICE]`: one JSON line a class of rays; see `report::bench_rays`.

use steradian::gpu::{Choice, Device, Options};

fn main() {
    let word = std::env::args().skip(1).find(|a| !a.starts_with('-')).unwrap_or("auto".into());
    let device = Device::open(&Choice::from(word.as_str()), &Options::default()).expect("a Vulkan device");
    for line in
        steradian::report::bench_rays::rays(&device, steradian::report::bench_rays::ROUNDS).expect("the device traces")
    {
        println!("{}", serde_json::to_string(&line).expect("plain fields"));
    }
}
