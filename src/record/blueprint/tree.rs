//! The tree of views and containers of a layout, and its encoding as a blueprint.
//!
//! A blueprint is itself a recording: a view is an archetype logged at `view/<id>`, with its contents and
//! properties at paths below. Rerun's own writer has no setters for most properties, and leaves two threads
//! behind for each blueprint.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use re_sdk_types::blueprint::archetypes::{
    Background, ContainerBlueprint, EyeControls3D, LineGrid3D, PanelBlueprint, PlotLegend,
    ScalarAxis, TimePanelBlueprint, ViewBlueprint, ViewContents, ViewportBlueprint,
    VisibleTimeRanges, VisualBounds2D,
};
use re_sdk_types::blueprint::components::{
    BackgroundKind, ContainerKind, Corner2D, PanelState, RootContainer,
};

use crate::record::sdk::datatypes::{
    Range1D, Range2D, TimeInt, TimeRange, TimeRangeBoundary, Uuid, VisibleTimeRange,
};
use crate::record::sdk::{Archetype, AsComponents, EntityPath, SerializedComponentBatch};

use crate::record::stream::{self, Moment, RecordingStream};
use crate::record::{paths, style};

/// A view, or parts side by side, below each other, or as tabs, each with its share; equal shares if none are given.
#[derive(Debug)]
pub enum Part {
    View(View),
    Group {
        kind: ContainerKind,
        name: Option<String>,
        parts: Vec<Part>,
        shares: Vec<f32>,
    },
}

impl Part {
    /// Parts below each other with equal shares, as a tab with a title.
    pub fn tab(title: &str, parts: Vec<Self>) -> Self {
        Self::Group {
            kind: ContainerKind::Vertical,
            name: Some(title.to_owned()),
            parts,
            shares: Vec::new(),
        }
    }
}

/// A view of some entities.
#[derive(Debug)]
pub struct View {
    class: &'static str,
    name: String,
    origin: EntityPath,
    contents: Vec<String>,
    /// Properties: path relative to the view, and components.
    properties: Vec<(&'static str, Vec<SerializedComponentBatch>)>,
}

impl View {
    /// A view of a class of Rerun, such as `TextDocument`, of the entities at and below a path.
    pub fn of(class: &'static str, name: impl Into<String>, origin: &str) -> Self {
        Self {
            class,
            name: name.into(),
            origin: origin.into(),
            contents: vec!["$origin/**".to_owned()],
            properties: Vec::new(),
        }
    }

    /// Time series over the whole run, with a legend in a corner, or without one, which would cover data: the title then
    /// explains the colours.
    pub fn series(name: impl Into<String>, paths: &[&str], legend: Option<Corner2D>) -> Self {
        let view = match (paths, legend) {
            ([path], None) => Self::of("TimeSeries", name, path),
            _ => Self::of("TimeSeries", name, "/").with_contents(paths),
        };
        view.with(&match legend {
            Some(corner) => PlotLegend::new().with_corner(corner),
            None => PlotLegend::new().with_visible(false),
        })
    }

    /// A two-dimensional plot with its own axes, completely visible.
    pub fn picture(name: impl Into<String>, path: &str, bounds: [[f32; 2]; 2]) -> Self {
        let [x_range, y_range] = bounds.map(|range| Range1D(range.map(f64::from)));
        let bounds = VisualBounds2D::new(Range2D { x_range, y_range });
        Self::of("2D", name, path).with(&bounds)
    }

    /// A cube of side 2 centred at the origin, seen from a distance in half edges.
    pub fn cube(name: impl Into<String>, path: &str, distance: f64) -> Self {
        let from = [0.57, -0.69, 0.45].map(|c| distance * c);
        Self::of("3D", name, path).with_eye(from, [0.0; 3], [0.0, 0.0, 1.0])
    }

    /// Shows these entities.
    pub fn with_contents(mut self, paths: &[&str]) -> Self {
        self.contents = paths.iter().map(|path| format!("+ /{path}")).collect();
        self
    }

    /// Sets a property.
    pub fn with<A: Archetype + AsComponents>(mut self, property: &A) -> Self {
        let batches = property.as_serialized_batches();
        self.properties.push((A::name().short_name(), batches));
        self
    }

    /// Limits the view to the last `window` s before the time cursor; infinite for the whole run.
    pub fn with_window(self, window: f64) -> Self {
        if window.is_infinite() {
            return self;
        }
        let range = VisibleTimeRange {
            timeline: paths::TIMELINE.into(),
            range: TimeRange {
                start: TimeRangeBoundary::CursorRelative(TimeInt(-stream::nanos(window))),
                end: TimeRangeBoundary::AT_CURSOR,
            },
        };
        self.with(&VisibleTimeRanges::new([range]))
    }

    /// Fixes the vertical range of a time series; the viewer chooses it if the range is empty.
    pub fn with_range(self, range: Option<[f64; 2]>) -> Self {
        let Some([low, high]) = range.filter(|[low, high]| low < high) else {
            return self;
        };
        let range = crate::record::sdk::components::Range1D::new(low, high);
        self.with(&ScalarAxis::new().with_range(range))
    }

    /// Sets the eye of a three-dimensional view: its place, the point at which it looks, and the upward direction.
    pub fn with_eye(self, from: [f64; 3], to: [f64; 3], up: [f64; 3]) -> Self {
        let [from, to, up] = [from, to, up].map(|v| v.map(|c| c as f32));
        let eye = EyeControls3D::new()
            .with_position(from)
            .with_look_target(to)
            .with_eye_up(up);
        let background = Background::new(BackgroundKind::SolidColor).with_color(style::BACKGROUND);
        self.with(&eye)
            .with(&LineGrid3D::new().with_visible(false))
            .with(&background)
    }
}

/// Writes a layout and activates it.
pub fn send(rec: &RecordingStream, tabs: Vec<Part>, time_panel: TimePanelBlueprint) {
    let mut writer = Writer {
        blueprint: rec.blueprint(),
        ids: HashMap::new(),
    };
    let root = writer.group(ContainerKind::Tabs, None, &tabs, &[]);
    let viewport = ViewportBlueprint::new()
        .with_root_container(RootContainer(Uuid {
            bytes: root.to_be_bytes(),
        }))
        .with_auto_layout(false)
        .with_auto_views(false);
    writer.log("viewport", &viewport);
    let hidden = PanelBlueprint::new().with_state(PanelState::Hidden);
    writer.log("blueprint_panel", &hidden);
    writer.log("selection_panel", &hidden);
    writer.log("time_panel", &time_panel.with_state(PanelState::Collapsed));
    match writer.blueprint.send_pending() {
        Ok(()) => rec.activate_blueprint(&writer.blueprint),
        Err(fault) => rec.fail(fault),
    }
}

struct Writer {
    blueprint: RecordingStream,
    /// Number of ids issued for each hash.
    ids: HashMap<u64, u64>,
}

impl Writer {
    fn log(&self, path: impl Into<EntityPath>, what: &dyn AsComponents) {
        let always = Moment::tick("blueprint".into(), 0);
        self.blueprint.log(path, always, what);
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
    fn part(&mut self, part: &Part) -> String {
        match part {
            Part::View(view) => self.view(view),
            Part::Group {
                kind,
                name,
                parts,
                shares,
            } => {
                let id = self.group(*kind, name.as_deref(), parts, shares);
                format!("container/{}", uuid(id))
            }
        }
    }

    /// Writes a group and returns its id.
    fn group(
        &mut self,
        kind: ContainerKind,
        name: Option<&str>,
        parts: &[Part],
        shares: &[f32],
    ) -> u128 {
        let parts: Vec<String> = parts.iter().map(|part| self.part(part)).collect();
        let id = self.id((kind as u8, name, &parts));
        let mut what = ContainerBlueprint::new(kind).with_contents(parts);
        if let Some(name) = name {
            what = what.with_display_name(name);
        }
        if !shares.is_empty() {
            let shares = shares.iter().copied();
            what = match kind {
                ContainerKind::Horizontal => what.with_col_shares(shares),
                _ => what.with_row_shares(shares),
            };
        }
        self.log(format!("container/{}", uuid(id)), &what);
        id
    }

    fn view(&mut self, view: &View) -> String {
        let origin = view.origin.to_string();
        let id = self.id((view.class, &view.name, &origin, &view.contents));
        let path = format!("view/{}", uuid(id));
        let contents = ViewContents::new(view.contents.iter().map(String::as_str));
        self.log(format!("{path}/ViewContents"), &contents);
        let what = ViewBlueprint::new(view.class)
            .with_display_name(view.name.as_str())
            .with_space_origin(origin);
        self.log(path.as_str(), &what);
        for (name, property) in &view.properties {
            self.log(format!("{path}/{name}"), property);
        }
        path
    }
}

/// An id in the format of Rerun.
fn uuid(id: u128) -> String {
    let hex = format!("{id:032x}");
    let parts = [0..8, 8..12, 12..16, 16..20, 20..32].map(|part| &hex[part]);
    parts.join("-")
}
