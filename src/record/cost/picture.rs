//! A plot of a setting.

use crate::plot::Panel;
use crate::record::panel_view::PanelView;

/// A plot of a setting.
pub struct Picture {
    /// Title of the view.
    pub name: &'static str,
    /// Entity and size of the plot.
    pub view: PanelView,
    /// Content of the plot.
    pub panel: Panel,
}
