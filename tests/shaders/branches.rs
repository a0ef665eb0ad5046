//! No branch of a fragment shader hangs on uniforms alone. Mesa's lavapipe puts the values of such
//! uniforms into the code and compiles the shader anew for each draw, which costs more than it draws;
//! what is one way for a whole picture is a define of the pipeline, or hangs on the pixel too.

use super::{SOURCES, Source, compose, defines};
use naga::{AddressSpace, Block, Expression, Function, Handle, Module, ShaderStage, Statement};
use std::collections::BTreeSet;

/// Small enough to be flattened: a debugger on lavapipe sees no compilation for it from frame to frame.
const FLATTENED: [(&str, &str); 1] = [("ocularium/gather.wgsl", "shown")];

/// What a value hangs on; of two the larger holds for what is made of both.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Origin {
    Constant,
    Uniform,
    Pixel,
}

/// A walk through a module from an entry point.
struct Walk<'m> {
    module: &'m Module,
    walked: BTreeSet<(Handle<Function>, Vec<Origin>)>,
    /// Functions with a branch on uniforms alone.
    found: BTreeSet<String>,
}

impl Walk<'_> {
    fn origin(&self, function: &Function, given: &[Origin], of: Handle<Expression>) -> Origin {
        let all = |parts: &[Handle<Expression>]| {
            let origins = parts.iter().map(|part| self.origin(function, given, *part));
            origins.max().unwrap_or(Origin::Constant)
        };
        use Expression as E;
        match &function.expressions[of] {
            E::Literal(_) | E::Constant(_) | E::Override(_) | E::ZeroValue(_) => Origin::Constant,
            E::GlobalVariable(global) => match self.module.global_variables[*global].space {
                AddressSpace::Uniform => Origin::Uniform,
                _ => Origin::Pixel,
            },
            E::FunctionArgument(index) => {
                given.get(*index as usize).copied().unwrap_or(Origin::Pixel)
            }
            E::Compose { components, .. } => all(components),
            E::Access { base, index } => all(&[*base, *index]),
            E::AccessIndex { base, .. } => all(&[*base]),
            E::Splat { value, .. } => all(&[*value]),
            E::Swizzle { vector, .. } => all(&[*vector]),
            E::Load { pointer } => all(&[*pointer]),
            E::Unary { expr, .. } | E::As { expr, .. } => all(&[*expr]),
            E::Binary { left, right, .. } => all(&[*left, *right]),
            E::Select {
                condition,
                accept,
                reject,
            } => all(&[*condition, *accept, *reject]),
            E::Relational { argument, .. } => all(&[*argument]),
            E::Math {
                arg,
                arg1,
                arg2,
                arg3,
                ..
            } => {
                let parts: Vec<_> = [Some(*arg), *arg1, *arg2, *arg3]
                    .into_iter()
                    .flatten()
                    .collect();
                all(&parts)
            }
            // Variables, textures, answers of functions: taken for what differs.
            _ => Origin::Pixel,
        }
    }

    fn block(&mut self, function: &Function, given: &[Origin], block: &Block) {
        let name = || function.name.clone().unwrap_or_default();
        for statement in block {
            match statement {
                Statement::If {
                    condition,
                    accept,
                    reject,
                } => {
                    if self.origin(function, given, *condition) == Origin::Uniform {
                        self.found.insert(name());
                    }
                    self.block(function, given, accept);
                    self.block(function, given, reject);
                }
                Statement::Switch { selector, cases } => {
                    if self.origin(function, given, *selector) == Origin::Uniform {
                        self.found.insert(name());
                    }
                    for case in cases {
                        self.block(function, given, &case.body);
                    }
                }
                Statement::Loop {
                    body, continuing, ..
                } => {
                    self.block(function, given, body);
                    self.block(function, given, continuing);
                }
                Statement::Block(inner) => self.block(function, given, inner),
                Statement::Call {
                    function: called,
                    arguments,
                    ..
                } => {
                    let given: Vec<Origin> = arguments
                        .iter()
                        .map(|argument| self.origin(function, given, *argument))
                        .collect();
                    if self.walked.insert((*called, given.clone())) {
                        let called = &self.module.functions[*called];
                        self.block(called, &given, &called.body);
                    }
                }
                _ => {}
            }
        }
    }
}

/// Functions that a fragment shader of this module comes to and that branch on uniforms alone.
fn uniform_branches(module: &Module) -> BTreeSet<String> {
    let mut walk = Walk {
        module,
        walked: BTreeSet::new(),
        found: BTreeSet::new(),
    };
    let fragments = module.entry_points.iter();
    for entry in fragments.filter(|entry| entry.stage == ShaderStage::Fragment) {
        walk.block(&entry.function, &[], &entry.function.body);
    }
    walk.found
}

#[test]
fn no_fragment_shader_branches_on_uniforms_alone() {
    let mut fragments = 0;
    for source in SOURCES {
        let text = source.text();
        let known = defines(&text);
        // All defines together reach every branch but those of `#else`, and none reaches these.
        for set in [known.iter().collect(), vec![]] {
            let module = compose(&text, source.name, &set).expect(source.name);
            let entries = module.entry_points.iter();
            fragments += entries.filter(|e| e.stage == ShaderStage::Fragment).count();
            let mut found = uniform_branches(&module);
            for (_, function) in FLATTENED.iter().filter(|(file, _)| *file == source.name) {
                assert!(found.remove(*function), "{function} has no such branch");
            }
            assert!(found.is_empty(), "{} with {set:?}: {found:?}", source.name);
        }
    }
    assert!(fragments >= 8, "{fragments}");
}

#[test]
fn a_branch_on_a_uniform_is_found_wherever_it_stands() {
    let globe: &Source = SOURCES
        .iter()
        .find(|source| source.name.ends_with("globe.wgsl"))
        .expect("the globe");
    let text = globe.text();
    // In the entry point's file, and where a function is given the whole uniform.
    for (from, to, function) in [
        (
            "if t > 0.0 {",
            "if globe.pupil_radius_mm > 0.0 {",
            "fragment",
        ),
        (
            "if is_window * along > 0.05 {",
            "if is_window > 0.05 {",
            "studio_radiance",
        ),
    ] {
        let broken = text.replace(from, to);
        assert_ne!(broken, text, "{from}");
        let cornea = "CORNEA".to_owned();
        let module = compose(&broken, "broken.wgsl", &[&cornea]).expect("valid");
        let found = uniform_branches(&module);
        assert!(
            found.iter().any(|name| name.starts_with(function)),
            "{found:?}"
        );
    }
}
