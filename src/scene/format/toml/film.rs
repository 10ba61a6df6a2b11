//! `[film]`: size, window, filter and stops.

use super::table::{Table, nearest};
use super::{Builder, choice, keys};
use crate::film::exposure::Shutter;
use crate::film::filter::{FilterKind, PixelFilter};
use crate::scene::{Error, Film, TextureFilter};

impl<'a> Builder<'a> {
    pub fn film(&mut self, top: &Table<'a>) -> Result<(), Error> {
        let Some(item) = top.get("film") else { return Ok(()) };
        let table = Table::open(self.source, item, &[&keys::FILM], &[])?;
        let film = &mut self.scene.film;
        if let Some(size) = table.numbers::<2>("size")? {
            if size.iter().any(|s| *s < 1.0 || *s > 65_536.0 || s.fract() != 0.0) {
                return Err(table.error("size", "must be two whole numbers of pixels from 1 to 65536"));
            }
            (film.width, film.height) = (size[0] as u32, size[1] as u32);
        }
        let count = |key| Ok::<_, Error>(table.whole(key, 1..1 << 31)?.map(|n| n as u32));
        film.spp = count("spp")?;
        film.max_depth = count("max_depth")?;
        let filters = [("exact", TextureFilter::Exact), ("mipmap", TextureFilter::Mipmap)];
        self.scene.texture_filter = choice(&table, "texture_filter", &filters)?;
        let film = &mut self.scene.film;
        if let Some(edges) = table.numbers::<4>("crop")? {
            if edges.iter().any(|e| e.fract() != 0.0 || !(0.0..=65_536.0).contains(e)) {
                return Err(table.error("crop", "must be four whole numbers of pixels: x0, y0, x1, y1"));
            }
            film.set_crop(edges.map(|e| e as u32)).map_err(|reason| table.error("crop", reason))?;
        }
        filter(&table, film)?;
        shutter(&table, film)
    }
}

fn shutter(table: &Table<'_>, film: &mut Film) -> Result<(), Error> {
    let keys = ["shutter_s", "iso", "f_number"];
    let mut values = [None; 3];
    for (value, key) in values.iter_mut().zip(keys) {
        *value = table.number(key)?;
        if value.is_some_and(|v| !(1e-12..=1e12).contains(&v)) {
            return Err(table.error(key, "must lie from 1e-12 to 1e12"));
        }
    }
    match values {
        [None, None, None] => {}
        [Some(time_s), Some(iso), Some(f_number)] => film.shutter = Some(Shutter { time_s, iso, f_number }),
        _ => {
            let missing = (0..3).find(|&k| values[k].is_none()).map_or("iso", |k| keys[k]);
            return Err(table.missing(missing));
        }
    }
    Ok(())
}

fn filter(table: &Table<'_>, film: &mut Film) -> Result<(), Error> {
    let radius = table.number("filter_radius")?;
    let kind = match table.text("filter")? {
        None => FilterKind::Box,
        Some(word) => FilterKind::ALL.iter().copied().find(|k| k.keyword() == word).ok_or_else(|| {
            let hint = nearest(word, FilterKind::ALL.iter().map(|k| k.keyword()));
            table.error("filter", format!("is \"{word}\", which is no filter; {hint}"))
        })?,
    };
    film.filter = PixelFilter::new(kind, radius).map_err(|reason| table.error("filter_radius", reason))?;
    Ok(())
}
