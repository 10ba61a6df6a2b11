//! Scene file formats, one file each.
