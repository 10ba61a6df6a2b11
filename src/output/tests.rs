//! Every format read back, paths refused before a render, nothing left behind.

use super::*;
use crate::film::aov::Aovs;
use crate::film::slot::SlotRecord;
use crate::prepare::records::NONE;

fn slot(pixel: usize, block: u64) -> SlotRecord {
    let v = 16.0 * (0.05 * pixel as f32 + 0.001 * block as f32);
    SlotRecord { sum: [v, 2.0 * v, 16.0], first_bad: NONE, ..Default::default() }
}

fn film() -> Film {
    let mut film = Film::new(4, 3, Aovs::usual(), 0);
    for pixel in 0..12 {
        for block in 0..2 {
            film.add_block(pixel, block, &slot(pixel, block));
        }
    }
    film
}

#[test]
fn exr_keeps_every_bit_units_and_record() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.exr");
    let record = Record { scene: "snow \"and\" ice".into(), spp: 32, ..Default::default() };
    write_picture(&path, &film(), &record, 0.0).unwrap();
    let picture = image::read(&path).unwrap();
    assert_eq!((picture.width, picture.height, &picture.pixels), (4, 3, &film().mean_f32()));
    let json = exr::read_record(&path).unwrap().unwrap();
    assert_eq!(serde_json::from_str::<Record>(&json).unwrap(), record);
    let meta = ::exr::meta::MetaData::read_from_file(&path, false).unwrap();
    let header = &meta.headers[0];
    let names: Vec<String> = header.channels.list.iter().map(|c| c.name.to_string()).collect();
    for name in ["R", "G", "B", "albedo.R", "normal.X", "depth.Z", "variance.B", "samples"] {
        assert!(names.iter().any(|n| n == name), "{name} in {names:?}");
        assert!(header.own_attributes.other.contains_key(&::exr::prelude::Text::from(format!("unit.{name}").as_str())));
    }
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1, "nothing is left beside");
}

#[test]
fn png_and_hdr_read_back() {
    let dir = tempfile::tempdir().unwrap();
    let film = film();
    for (name, bound) in [("a.png", 0.006), ("a.hdr", 0.01)] {
        let path = dir.path().join(name);
        write_picture(&path, &film, &Record::default(), 0.0).unwrap();
        let picture = image::read(&path).unwrap();
        for (x, r) in picture.pixels.iter().flatten().zip(film.mean_f32().iter().flatten()) {
            let r = if name == "a.png" { r.min(1.0) } else { *r };
            assert!((x - r).abs() <= bound, "{name}: {x} for {r}");
        }
    }
    assert_eq!(image::srgb_encode(f32::NAN), 0.0);
    assert!((image::srgb_decode(image::srgb_encode(0.2)) - 0.2).abs() < 1e-6);
}

/// A picture written band by band has the pixels, layers, units and record of one written whole.
#[test]
fn bands_make_the_same_files() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name);
    let record = Record { scene: "bands".into(), width: 4, height: 3, ..Default::default() };
    let look = Look { exposure_ev: -1.0, tonemap: look::Tonemap::Neutral };
    let whole = film();
    let names = crate::film::aov::Names::default();
    let subject =
        bands::Subject { window: whole.window(), whole: (4, 3), aovs: whole.aovs(), names: &names, look, said: 0 };
    let paths = ["b.exr", "b.png", "b.hdr"].map(path).to_vec();
    let mut written = bands::Bands::begin(&paths, &subject).unwrap();
    for (first, rows) in [(0, 2), (2, 1)] {
        let window = crate::film::Tile { x: 0, y: first, width: 4, height: rows };
        let mut part = Film::over(window, whole.aovs(), 0);
        for pixel in 0..part.pixel_count() {
            (0..2).for_each(|block| part.add_block(pixel, block, &slot(pixel + 4 * first as usize, block)));
        }
        written.write(&part).unwrap();
    }
    written.finish(&record).unwrap();
    for (name, other) in [("a.exr", "b.exr"), ("a.png", "b.png"), ("a.hdr", "b.hdr")] {
        write_picture(&path(name), &whole, &record, look).unwrap();
        assert_eq!(image::read(&path(name)).unwrap(), image::read(&path(other)).unwrap(), "{name}");
    }
    let header = |name: &str| ::exr::meta::MetaData::read_from_file(path(name), false).unwrap().headers[0].clone();
    let (a, b) = (header("a.exr"), header("b.exr"));
    assert_eq!(a.channels, b.channels);
    assert_eq!(a.shared_attributes.display_window, b.shared_attributes.display_window);
    assert_eq!(a.own_attributes.other.len(), b.own_attributes.other.len());
    let in_header = exr::read_record(&path("b.exr")).unwrap().unwrap();
    assert_eq!(serde_json::from_str::<Record>(in_header.trim_end()).unwrap(), record);
    // Begun and dropped: nothing is left.
    drop(bands::Bands::begin(&[path("c.exr"), path("c.hdr")], &subject).unwrap());
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 6);
}

/// A picture that ends early: the rows below are as those of an empty film, and a long record does not stand in the way.
#[test]
fn blank_rows_and_long_records_end_a_picture() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name);
    let (whole, names, look) = (film(), crate::film::aov::Names::default(), Look::default());
    let window = crate::film::Tile { x: 3, y: 7, width: 4, height: 9 };
    let notes: Vec<String> = (0..3000).map(|k| format!("note {k}: \"{}\"", "x".repeat(40))).collect();
    let said: usize = notes.iter().map(String::len).sum();
    for (said, is_cut) in [(said, false), (0, true)] {
        let subject = bands::Subject { window, whole: (9, 20), aovs: whole.aovs(), names: &names, look, said };
        let paths = ["b.exr", "b.png", "b.hdr"].map(path).to_vec();
        let mut written = bands::Bands::begin(&paths, &subject).unwrap();
        let mut part = Film::over(crate::film::Tile { height: 2, ..window }, whole.aovs(), 0);
        for pixel in 0..part.pixel_count() {
            (0..2).for_each(|block| part.add_block(pixel, block, &slot(pixel, block)));
        }
        written.write(&part).unwrap();
        let row = Film::over(crate::film::Tile { height: 1, ..window }, whole.aovs(), 0);
        written.write_blank(&row, 7).unwrap();
        let record = Record { notes: notes.clone(), command: "render".into(), ..Default::default() };
        written.finish(&record).unwrap();
        for (path, bound) in paths.iter().zip([0.0, 0.003, 0.01]) {
            let picture = image::read(path).unwrap();
            assert_eq!((picture.width, picture.height), (4, 9), "{}", path.display());
            for (k, pixel) in picture.pixels.iter().enumerate() {
                let wanted = if k < 8 { part.mean_f32()[k] } else { [0.0; 3] };
                assert!((0..3).all(|c| (pixel[c] - wanted[c]).abs() <= bound), "{} {k} {pixel:?}", path.display());
            }
        }
        let depth = exr::read_channels(&path("b.exr"), ["depth.Z", "variance.R", "samples"]).unwrap().unwrap();
        assert_eq!((depth[7][2], depth[8]), (32.0, [f32::INFINITY, f32::INFINITY, 0.0]));
        let json = exr::read_record(&path("b.exr")).unwrap().unwrap();
        let back: Record = serde_json::from_str(json.trim_end()).unwrap();
        match is_cut {
            false => assert_eq!(back, record),
            true => assert!(
                back.notes.len() > 500 && back.notes.last().unwrap().contains("had no room"),
                "{:?}",
                back.notes.last()
            ),
        }
    }
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 3, "nothing is left beside");
}

#[test]
fn unwritable_paths_are_refused_before() {
    let dir = tempfile::tempdir().unwrap();
    let refusal = |path: &Path| check_picture(path).unwrap_err().to_string();
    assert!(refusal(&dir.path().join("a.tif")).ends_with("use .exr, .png or .hdr"));
    assert!(refusal(&dir.path().join("missing/a.exr")).contains("no such file or directory"));
    std::fs::create_dir(dir.path().join("d.exr")).unwrap();
    assert!(refusal(&dir.path().join("d.exr")).ends_with("it is a directory"));
    assert!(check_picture(&dir.path().join("fine.exr")).is_ok());
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1, "checking leaves nothing");
}

#[test]
fn a_failed_write_leaves_the_old_file() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.json");
    write_atomically(&path, b"old").unwrap();
    let failed = replace(&path, |beside| {
        std::fs::write(beside, b"half").unwrap();
        Err(Error::Usage("stopped".into()))
    });
    assert!(failed.is_err());
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
}

#[test]
fn peak_memory_is_known_here() {
    assert!(record::peak_host_bytes() > 1 << 20);
}
