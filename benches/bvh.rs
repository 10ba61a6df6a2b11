//! `cargo bench --bench bvh`: one JSON line, the build of 401,420 triangles; see `report::bench_rays`.

fn main() {
    println!(
        "{}",
        serde_json::to_string(&steradian::report::bench_rays::build(steradian::report::bench_rays::ROUNDS))
            .expect("plain fields")
    );
}
