//! Rerun recordings: the only room that names an entity path.
