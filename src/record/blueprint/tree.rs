//! The tree of views and containers of a layout, and its encoding as a blueprint.
//!
//! A blueprint is itself a recording: a view is an archetype logged at `view/<id>`, with its contents and
//! properties at paths below. Rerun's own writer has no setters for most properties, and leaves two threads
//! behind for each blueprint.

use std::{
    collections::HashMap,
    hash::{DefaultHasher, Hash, Hasher},
    sync::atomic::{AtomicU64, Ordering},
};

use rerun::{
    EntityPath, SerializedComponentBatch,
    datatypes::Uuid,
    external::re_sdk_types::blueprint::{
        archetypes::{
            ContainerBlueprint, PanelBlueprint, TimePanelBlueprint, ViewBlueprint, ViewContents,
            ViewportBlueprint,
        },
        components::{ContainerKind, PanelState, RootContainer},
    },
};

use crate::record::{
    error::RecordError,
    stream::{self, Moment, RecordingStream},
};

/// A view or a container of views, wherever one is like the other.
#[derive(Debug)]
pub enum ContainerLike {
    View(View),
    Container(Container),
}

/// A view of some entities.
#[derive(Debug)]
pub struct View {
    /// Unique key of the view.
    key: u64,
    class: &'static str,
    name: String,
    origin: EntityPath,
    contents: Vec<String>,
}

impl View {
    /// A view of three-dimensional shapes.
    pub fn in_3d(name: impl Into<String>) -> Self {
        Self::of_class("3D", name)
    }

    /// A view of two-dimensional plots.
    pub fn in_2d(name: impl Into<String>) -> Self {
        Self::of_class("2D", name)
    }

    /// A view of scalars over time.
    pub fn time_series(name: impl Into<String>) -> Self {
        Self::of_class("TimeSeries", name)
    }

    /// A view of states over time.
    pub fn state_timeline(name: impl Into<String>) -> Self {
        Self::of_class("StateTimeline", name)
    }

    /// A view of a text document.
    pub fn text_document(name: impl Into<String>) -> Self {
        Self::of_class("TextDocument", name)
    }

    /// A view of log messages with their times.
    pub fn text_log(name: impl Into<String>) -> Self {
        Self::of_class("TextLog", name)
    }

    fn of_class(class: &'static str, name: impl Into<String>) -> Self {
        static KEYS: AtomicU64 = AtomicU64::new(0);
        Self {
            key: KEYS.fetch_add(1, Ordering::Relaxed),
            class,
            name: name.into(),
            origin: EntityPath::root(),
            contents: vec!["$origin/**".to_owned()],
        }
    }

    /// Shows the entities at and below a path.
    #[must_use]
    pub fn with_origin(mut self, origin: impl Into<EntityPath>) -> Self {
        self.origin = origin.into();
        self
    }

    /// Shows the entities selected by queries.
    #[must_use]
    pub fn with_contents(mut self, queries: impl IntoIterator<Item = impl Into<String>>) -> Self {
        self.contents = queries.into_iter().map(Into::into).collect();
        self
    }

    /// Unique key of the view.
    pub fn key(&self) -> u64 {
        self.key
    }
}

impl From<View> for ContainerLike {
    fn from(view: View) -> Self {
        Self::View(view)
    }
}

/// A container: views side by side, below each other, or as tabs.
#[derive(Debug)]
pub struct Container {
    kind: ContainerKind,
    name: Option<String>,
    contents: Vec<ContainerLike>,
    shares: Vec<f32>,
}

impl Container {
    /// Tabs, one visible at a time.
    pub fn tabs(contents: Vec<ContainerLike>) -> Self {
        Self {
            kind: ContainerKind::Tabs,
            name: None,
            contents,
            shares: Vec::new(),
        }
    }

    /// Views side by side, each with its share of the width.
    pub fn row(contents: Vec<ContainerLike>, shares: Vec<f32>) -> Self {
        Self {
            kind: ContainerKind::Horizontal,
            shares,
            ..Self::tabs(contents)
        }
    }

    /// Views below each other, each with its share of the height; equal shares if none are given.
    pub fn column(contents: Vec<ContainerLike>, shares: Vec<f32>) -> Self {
        Self {
            kind: ContainerKind::Vertical,
            shares,
            ..Self::tabs(contents)
        }
    }

    /// Sets the display name.
    #[must_use]
    pub fn with_name(mut self, name: &str) -> Self {
        self.name = Some(name.to_owned());
        self
    }
}

impl From<Container> for ContainerLike {
    fn from(container: Container) -> Self {
        Self::Container(container)
    }
}

/// Properties of views by their keys: path relative to the view, and components.
pub type Properties = HashMap<u64, Vec<(&'static str, Vec<SerializedComponentBatch>)>>;

/// Writes a layout and activates it.
pub fn send(
    rec: &RecordingStream,
    screen: &Container,
    time_panel: &TimePanelBlueprint,
    properties: Properties,
) -> Result<(), RecordError> {
    let mut writer = Writer {
        blueprint: rec.blueprint(),
        properties,
        ids: HashMap::new(),
    };
    let root = writer.container(screen)?;
    let viewport = ViewportBlueprint::new()
        .with_root_container(RootContainer(Uuid {
            bytes: root.to_be_bytes(),
        }))
        .with_auto_layout(false)
        .with_auto_views(false);
    writer.log("viewport", &viewport)?;
    let hidden = PanelBlueprint::new().with_state(PanelState::Hidden);
    writer.log("blueprint_panel", &hidden)?;
    writer.log("selection_panel", &hidden)?;
    writer.log("time_panel", time_panel)?;
    writer.blueprint.send_pending()?;
    rec.activate_blueprint(&writer.blueprint);
    Ok(())
}

struct Writer {
    blueprint: RecordingStream,
    properties: Properties,
    /// Number of ids issued for each hash.
    ids: HashMap<u64, u64>,
}

impl Writer {
    fn log(
        &self,
        path: impl Into<EntityPath>,
        what: &dyn rerun::AsComponents,
    ) -> Result<(), RecordError> {
        let always = Moment::tick("blueprint".into(), 0);
        stream::log_at(&self.blueprint, path, always, what)
    }

    /// An id that is the same for the same layout. Rerun interns every name permanently, so unique ids for
    /// each recording would leak memory.
    fn id(&mut self, of: impl Hash) -> u128 {
        let mut hasher = DefaultHasher::new();
        of.hash(&mut hasher);
        let hash = hasher.finish();
        let count = self.ids.entry(hash).or_default();
        *count += 1;
        u128::from(hash) << 64 | u128::from(*count)
    }

    /// Writes a part of the tree and returns its path.
    fn part(&mut self, part: &ContainerLike) -> Result<String, RecordError> {
        match part {
            ContainerLike::View(view) => self.view(view),
            ContainerLike::Container(container) => {
                Ok(format!("container/{}", uuid(self.container(container)?)))
            }
        }
    }

    fn container(&mut self, container: &Container) -> Result<u128, RecordError> {
        let parts = container.contents.iter().map(|part| self.part(part));
        let parts = parts.collect::<Result<Vec<_>, _>>()?;
        let id = self.id((container.kind as u8, &container.name, &parts));
        let mut what = ContainerBlueprint::new(container.kind).with_contents(parts);
        if let Some(name) = &container.name {
            what = what.with_display_name(name.as_str());
        }
        let shares = container.shares.iter().copied();
        if shares.len() > 0 {
            what = match container.kind {
                ContainerKind::Horizontal => what.with_col_shares(shares),
                _ => what.with_row_shares(shares),
            };
        }
        self.log(format!("container/{}", uuid(id)), &what)?;
        Ok(id)
    }

    fn view(&mut self, view: &View) -> Result<String, RecordError> {
        let origin = view.origin.to_string();
        let id = self.id((view.class, &view.name, &origin, &view.contents));
        let path = format!("view/{}", uuid(id));
        let contents = ViewContents::new(view.contents.iter().map(String::as_str));
        self.log(format!("{path}/ViewContents"), &contents)?;
        let what = ViewBlueprint::new(view.class)
            .with_display_name(view.name.as_str())
            .with_space_origin(origin);
        self.log(path.as_str(), &what)?;
        for (name, property) in self.properties.remove(&view.key).unwrap_or_default() {
            self.log(format!("{path}/{name}"), &property)?;
        }
        Ok(path)
    }
}

/// An id in the format of Rerun.
fn uuid(id: u128) -> String {
    let hex = format!("{id:032x}");
    let parts = [0..8, 8..12, 12..16, 16..20, 20..32].map(|part| &hex[part]);
    parts.join("-")
}
