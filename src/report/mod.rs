//! Reports: what `inspect` and `bench` print.

pub mod inspect;
pub mod samples;
pub mod specialise;
