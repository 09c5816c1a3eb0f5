//! A picture of a knob, which is laid out and drawn.

use crate::plot::Panel;
use crate::record::figure::View;

/// A picture of a knob.
pub struct Picture {
    /// Its name.
    pub name: &'static str,
    /// Where it is drawn.
    pub view: View,
    /// What is drawn.
    pub panel: Panel,
}
