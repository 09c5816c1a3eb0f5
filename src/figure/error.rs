//! What can go wrong with a figure.

use thiserror::Error;

use crate::joint::AssemblyError;

/// Why there is no figure.
#[derive(Debug, Error)]
pub enum FigureError {
    /// It could not be drawn.
    #[error("the figure `{title}` could not be drawn: {reason}")]
    Draw {
        /// Title of the figure.
        title: String,
        /// What the plot library says.
        reason: String,
    },
    /// It could not be turned into pixels.
    #[error("the figure could not be turned into pixels: {0}")]
    Raster(String),
    /// There is no mesh to draw.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
}
