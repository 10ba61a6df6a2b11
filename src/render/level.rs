//! Pixels that a stopped pass left behind get the blocks they lack, block by block, so that the film is that of a render which
//! was never stopped, to the bit.

use crate::error::Error;
use crate::film::Film;
use crate::film::source::SampleSource;

/// Renders until all pixels have as many blocks as the furthest, or until `interrupted`. Returns the rays traced.
pub fn level(source: &mut dyn SampleSource, film: &mut Film, interrupted: &dyn Fn() -> bool) -> Result<u64, Error> {
    let mut rays = 0;
    while film.min_block_count() < film.max_block_count() {
        let block = film.first_block() + u64::from(film.min_block_count());
        for tile in film.lowest() {
            let mut part = Film::over(tile, film.aovs(), block);
            rays += source.render_blocks(block..block + 1, &mut part, interrupted)?.rays;
            film.add_film(&part);
            if interrupted() {
                return Ok(rays);
            }
        }
    }
    Ok(rays)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::time::Instant;

    use super::*;
    use crate::film::Tile;
    use crate::film::aov::Aovs;
    use crate::film::noise::{Noise, bits, film};
    use crate::render::{Stops, render_film};

    /// Stopped after any tile of any pass, once or over and over: the film that goes on is that of one run, every bit of it.
    #[test]
    fn a_render_that_was_stopped_goes_on_to_the_bits_of_one_run() {
        let window = Tile { x: 1, y: 2, width: 8, height: 4 };
        let aovs = Aovs::usual().with("material");
        let mut source = Noise { size: (9, 6), aovs };
        let one = film(window, aovs, 2..10);
        let stops = Stops { blocks: Some(8), time_s: None, error: None, started: Instant::now() };
        for every in 1..60 {
            let mut film = Film::over(window, aovs, 2);
            let mut stopped = 0;
            loop {
                let polls = Cell::new(0);
                let interrupted = || {
                    polls.set(polls.get() + 1);
                    polls.get() > every
                };
                let outcome = render_film(&mut source, film, &stops, &interrupted, &mut |_, _| Ok(())).unwrap();
                film = outcome.film;
                stopped += 1;
                if film.min_block_count() == 8 && film.max_block_count() == 8 {
                    break;
                }
                assert!(stopped < 1000, "it goes on");
            }
            assert!(stopped > 1 || every > 12, "{every}");
            assert_eq!(bits(&film), bits(&one), "stopped every {every} tiles");
            assert_eq!((film.ray_count(), film.ledger().nan), (one.ray_count(), one.ledger().nan));
        }
    }

    #[test]
    fn a_film_of_other_layers_is_refused() {
        let film = Film::over(Tile::image(4, 3), Aovs::usual(), 0);
        let stops = Stops { blocks: Some(4), time_s: None, error: None, started: Instant::now() };
        let mut source = Noise { size: (4, 3), aovs: Aovs::NONE };
        let error = render_film(&mut source, film, &stops, &|| false, &mut |_, _| Ok(())).unwrap_err().to_string();
        assert!(error.contains("keeps albedo") && error.contains("with none"), "{error}");
    }

    #[test]
    fn a_film_that_has_enough_is_left_alone() {
        let window = Tile::image(4, 3);
        let whole = film(window, Aovs::NONE, 0..6);
        let stops = Stops { blocks: Some(4), time_s: None, error: None, started: Instant::now() };
        let mut source = Noise { size: (4, 3), aovs: Aovs::NONE };
        let outcome = render_film(&mut source, whole.clone(), &stops, &|| false, &mut |_, _| Ok(())).unwrap();
        assert_eq!((outcome.rays, bits(&outcome.film)), (0, bits(&whole)));
        assert!(outcome.error.is_some());
    }
}
