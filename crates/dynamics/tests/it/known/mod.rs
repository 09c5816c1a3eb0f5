//! Systems with known exponents.

mod henon_heiles;
mod lorenz;
mod roessler;

pub use henon_heiles::HenonHeiles;
pub use lorenz::Lorenz;
pub use roessler::Roessler;
