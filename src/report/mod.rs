//! Reports: what `inspect` and `bench` print, and the study of `converge`.

pub mod bench_instances;
pub mod bench_rays;
pub mod converge;
pub mod coverage;
pub mod exponents;
pub mod inspect;
pub mod mis_bound;
pub mod overhead;
pub mod panels;
pub mod provenance;
pub mod replicates;
pub mod samples;
pub mod sheet;
pub mod specialise;
