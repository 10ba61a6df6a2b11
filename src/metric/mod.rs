//! Error measures of images, and the statistics that say how far they can be trusted.

pub mod error;
pub mod estimate;
pub mod flip;
pub mod special;
pub mod stats;
