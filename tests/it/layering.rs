//! Allowed dependencies between the modules, checked on every path in the source.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};

/// Modules, and the modules that each may use.
const EDGES: &[(&str, &[&str])] = &[
    ("fem", &["memory"]),
    ("dynamics", &[]),
    ("memory", &[]),
    ("analysis", &["memory"]),
    ("numpy", &["foreign", "memory"]),
    ("foreign", &[]),
    ("joint", &["fem", "dynamics", "numpy"]),
    ("systems", &["dynamics"]),
    (
        "scene",
        &["fem", "joint", "systems", "dynamics", "analysis", "foreign"],
    ),
    (
        "pipeline",
        &[
            "memory", "fem", "joint", "systems", "dynamics", "analysis", "scene",
        ],
    ),
    (
        "text",
        &["analysis", "dynamics", "scene", "pipeline", "study"],
    ),
    ("export", &["joint", "pipeline", "numpy"]),
    ("import", &["foreign", "memory", "numpy"]),
    (
        "record",
        &[
            "memory", "fem", "joint", "analysis", "dynamics", "pipeline", "scene", "text",
            "export", "foreign", "study", "plot",
        ],
    ),
    (
        "study",
        &[
            "joint", "dynamics", "analysis", "scene", "pipeline", "export", "foreign", "import",
            "memory",
        ],
    ),
    // Figures are functions of results: they compute nothing, and do not depend on their backend.
    (
        "plot",
        &[
            "fem", "joint", "analysis", "dynamics", "scene", "pipeline", "study",
        ],
    ),
    ("sound", &["pipeline", "export"]),
    (
        "live",
        &[
            "analysis", "scene", "pipeline", "text", "record", "sound", "study", "plot",
        ],
    ),
    (
        "cli",
        &[
            "fem", "joint", "dynamics", "analysis", "scene", "pipeline", "record", "study",
            "export", "import", "plot", "sound", "live", "memory", "text",
        ],
    ),
];

/// Path of a module or an item from the crate root.
type Names = Vec<String>;

/// A source file: its module and its references.
#[derive(Default)]
struct Module {
    module: Names,
    /// Paths in `use` items and in code.
    paths: Vec<Names>,
    /// Names that `use` brings into scope, with their paths.
    scope: BTreeMap<String, Names>,
    /// Names among them that are re-exported.
    exports: BTreeMap<String, Names>,
    /// First segments of paths, and first two segments: crates and modules used by name.
    names: BTreeSet<String>,
}

impl Module {
    fn read(file: &Path) -> Self {
        let place = file.strip_prefix(source()).unwrap().with_extension("");
        let mut module: Names = place
            .iter()
            .map(|part| part.to_str().unwrap().to_owned())
            .collect();
        if matches!(
            module.last().map(String::as_str),
            Some("mod" | "lib" | "main")
        ) {
            module.pop();
        }
        let parsed = syn::parse_file(&fs::read_to_string(file).unwrap()).unwrap();
        let mut found = Self {
            module,
            ..Self::default()
        };
        found.visit_file(&parsed);
        found
    }

    /// Records a path as written.
    fn take(&mut self, path: &[String]) -> Names {
        self.names.insert(path[0].clone());
        let first_two = path.get(..2).map(|names| names.join("::"));
        self.names.extend(first_two);
        absolute(&self.module, path)
    }

    /// Records a path in code: relative to a name in scope, or as written.
    fn take_in_code(&mut self, names: Names) {
        let path = self.take(&names);
        let path = match self.scope.get(&names[0]) {
            Some(meant) => [meant, &names[1..]].concat(),
            None => path,
        };
        self.paths.push(path);
    }

    fn take_tree(&mut self, prefix: &[String], tree: &syn::UseTree, export: bool) {
        let mut path = prefix.to_vec();
        let name = match tree {
            syn::UseTree::Path(tree) => {
                path.push(tree.ident.to_string());
                return self.take_tree(&path, &tree.tree, export);
            }
            syn::UseTree::Group(group) => {
                let trees = group.items.iter();
                return trees.for_each(|tree| self.take_tree(prefix, tree, export));
            }
            syn::UseTree::Name(tree) if tree.ident == "self" => path.last().unwrap().clone(),
            syn::UseTree::Name(tree) => {
                path.push(tree.ident.to_string());
                tree.ident.to_string()
            }
            syn::UseTree::Rename(tree) => {
                path.push(tree.ident.to_string());
                tree.rename.to_string()
            }
            syn::UseTree::Glob(_) => "*".to_owned(),
        };
        let path = self.take(&path);
        self.scope.insert(name.clone(), path.clone());
        if export {
            self.exports.insert(name, path);
        } else {
            self.paths.push(path);
        }
    }
}

impl<'ast> Visit<'ast> for Module {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if !is_test_item(item) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        let is_private = matches!(item.vis, syn::Visibility::Inherited);
        self.take_tree(&[], &item.tree, !is_private);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Names = path
            .segments
            .iter()
            .map(|segment| segment.ident.to_string())
            .collect();
        if names.len() > 1 {
            self.take_in_code(names);
        }
        visit::visit_path(self, path);
    }

    /// In the arguments of a macro, any text that looks like a path counts as one.
    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        let text = call.tokens.to_string().replace(" :: ", "::");
        let words = text.split(|c: char| !(c.is_alphanumeric() || "_:".contains(c)));
        for word in words.filter(|word| word.contains("::")) {
            let names: Names = word
                .split("::")
                .filter(|name| !name.is_empty())
                .map(str::to_owned)
                .collect();
            if names.len() > 1 {
                self.take_in_code(names);
            }
        }
        visit::visit_macro(self, call);
    }
}

fn is_test_item(item: &syn::Item) -> bool {
    let attributes = match item {
        syn::Item::Mod(item) => &item.attrs,
        syn::Item::Fn(item) => &item.attrs,
        syn::Item::Use(item) => &item.attrs,
        syn::Item::Impl(item) => &item.attrs,
        syn::Item::Struct(item) => &item.attrs,
        syn::Item::Const(item) => &item.attrs,
        _ => return false,
    };
    attributes.iter().any(|attribute| match &attribute.meta {
        syn::Meta::List(list) => {
            let condition = list.tokens.to_string();
            list.path.is_ident("cfg") && (condition == "test" || condition.starts_with("all (test"))
        }
        _ => false,
    })
}

/// A path of a module as an absolute path. A path that starts with another name is taken as that of a child
/// module; if the name is a crate's, the path has no target.
fn absolute(module: &[String], path: &[String]) -> Names {
    let mut base = module.to_vec();
    let mut rest = path;
    match rest[0].as_str() {
        "crate" => {
            base.clear();
            rest = &rest[1..];
        }
        "self" => rest = &rest[1..],
        _ => {}
    }
    while rest.first().is_some_and(|name| name == "super") {
        base.pop();
        rest = &rest[1..];
    }
    base.extend_from_slice(rest);
    base
}

/// The source files without tests.
fn modules() -> Vec<Module> {
    rust_files(&source())
        .iter()
        .map(|file| Module::read(file))
        .collect()
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path
            .file_stem()
            .unwrap()
            .to_str()
            .unwrap()
            .contains("tests")
        {
            continue;
        }
        if path.is_dir() {
            found.extend(rust_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found
}

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Dependencies between the top-level modules that are not allowed, and allowed ones that are unused.
fn wrong_edges(modules: &[Module], allowed: &[(&str, &[&str])]) -> Vec<String> {
    let mut used: BTreeMap<(&str, &str), &Names> = BTreeMap::new();
    for module in modules.iter().filter(|module| !module.module.is_empty()) {
        for path in module.paths.iter().chain(module.exports.values()) {
            let (from, to) = (module.module[0].as_str(), path.first());
            if let Some(to) = to.filter(|to| *to != from) {
                used.entry((from, to)).or_insert(&module.module);
            }
        }
    }
    let is_listed = |name: &str| allowed.iter().any(|(module, _)| *module == name);
    let mut wrong = Vec::new();
    for (&(from, to), module) in &used {
        let row = allowed.iter().find(|(module, _)| *module == from);
        let is_allowed = row.is_none_or(|(_, uses)| uses.contains(&to));
        if is_listed(to) && !is_allowed {
            wrong.push(format!(
                "{} uses `{to}`, which is not allowed",
                module.join("::")
            ));
        }
    }
    for (from, uses) in allowed {
        for to in uses.iter().filter(|to| !used.contains_key(&(from, to))) {
            wrong.push(format!("`{from}` is allowed to use `{to}`, but does not"));
        }
    }
    wrong
}

#[test]
fn modules_use_exactly_the_allowed_modules() {
    let wrong = wrong_edges(&modules(), EDGES);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_module_is_listed() {
    for entry in fs::read_dir(source()).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        if entry.path().is_dir() && name != "guide" {
            assert!(
                EDGES.iter().any(|(module, _)| *module == name),
                "add a row for the module `{name}`"
            );
        }
    }
}

/// Every form of a path is found.
#[test]
fn paths_are_found_in_every_form() {
    let read = |name: &str, text: &str| {
        let mut module = Module {
            module: name.split("::").map(str::to_owned).collect(),
            ..Module::default()
        };
        module.visit_file(&syn::parse_file(text).unwrap());
        module
    };
    for text in [
        "use crate::b::X;",
        "use crate::{c::Y, b::{self, X}};",
        "fn f() { crate::b::f(); }",
        "fn f() { println!(\"{}\", crate::b::f()); }",
        "fn f(x: super::b::X) {}",
        "use super::{b as other};",
    ] {
        let modules = [read("a", text), read("b", ""), read("c", "")];
        let wrong = wrong_edges(&modules, &[("a", &["c"]), ("b", &[]), ("c", &[])]);
        assert_eq!(wrong[0], "a uses `b`, which is not allowed", "{text}");
    }
    let unused = wrong_edges(&[read("a", "")], &[("a", &["b"]), ("b", &[])]);
    assert_eq!(unused, ["`a` is allowed to use `b`, but does not"]);
    let test = "#[cfg(test)] mod tests { use crate::b::X; }";
    assert!(wrong_edges(&[read("a", test)], &[("a", &[]), ("b", &[])]).is_empty());
}

/// Rerun, clap, threads and other dependencies are confined to few modules.
#[test]
fn dependencies_stay_in_their_modules() {
    let modules = modules();
    for (what, homes) in [
        ("rerun", "record"),
        // Choices of figures and studies are command-line options themselves.
        ("clap", "cli plot study"),
        ("clap_complete", "cli"),
        ("clap_mangen", "cli"),
        // A viewer may hang, so its connection has a thread that can be abandoned.
        ("std::thread", "pipeline study record live"),
        ("crossbeam_channel", "pipeline study record"),
        ("arrow_array", "foreign study"),
        ("arrow_ipc", "foreign study"),
        ("serde_arrow", "study"),
        ("csv::Writer", "study"),
        ("parquet", "foreign study"),
        // Eigenvalues and linear systems, also of equilibria and of branches.
        ("faer", "fem joint dynamics study"),
        ("realfft", "analysis"),
        ("rustfft", "analysis"),
        // The program creates the thread pool before any work, because creating it may fail.
        ("rayon", "analysis pipeline cli"),
        ("minijinja", "text"),
        ("npyz", "numpy"),
        ("symphonia", "import"),
        ("matfile", "import"),
        ("axum", "live"),
        ("tokio", "live"),
        ("rubato", "sound"),
    ] {
        let users = modules.iter().filter(|module| module.names.contains(what));
        for user in users {
            let inside = homes.split(' ').any(|home| home == user.module[0]);
            assert!(inside, "{} uses {what}", user.module.join("::"));
        }
    }
}
