//! Every format read back, paths refused before a render, nothing left behind.

use super::*;
use crate::film::aov::Aovs;
use crate::film::slot::SlotRecord;
use crate::prepare::records::NONE;

fn film() -> Film {
    let mut film = Film::new(4, 3, Aovs::usual(), 0);
    for pixel in 0..12 {
        for block in 0..2 {
            let v = 16.0 * (0.05 * pixel as f32 + 0.001 * block as f32);
            film.add_block(
                pixel,
                block,
                &SlotRecord { sum: [v, 2.0 * v, 16.0], first_bad: NONE, ..Default::default() },
            );
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
