//! Box: the same weight everywhere up to the radius. Of half a pixel it is the pixel's own square. Keyword `box`.

use super::Shape;

pub const SHAPE: Shape = Shape { doc: "the same everywhere", radius: 0.5, density: |_| 0.5, tail: |t| 0.5 * (1.0 - t) };
