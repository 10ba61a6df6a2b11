//! Reports: what `inspect` and `bench` print.

pub mod inspect;
