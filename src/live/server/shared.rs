//! State shared by the request handlers of the page.

use std::sync::Arc;

use super::second::SecondRun;
use crate::live::session::Session;
use crate::live::tour::Tour;

/// Data shared by all connections of the page.
pub struct Shared {
    pub session: Arc<Session>,
    /// Address for an audience that only watches; `None` if only this machine can reach the page.
    pub audience_url: Option<String>,
    /// The bookmarks that ship.
    pub bookmarks: Option<Tour>,
    /// A second run for comparison.
    pub second: Option<SecondRun>,
}
