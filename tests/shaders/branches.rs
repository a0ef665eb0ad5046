//! No branch of a fragment shader hangs on uniforms alone. Mesa's lavapipe puts the values of such
//! uniforms into the code and compiles the shader anew for each draw, which costs more than it draws;
//! what is one way for a whole picture is a define of the pipeline, or hangs on the pixel too.

use super::{SOURCES, Source, compose, defines};
use naga::{
    AddressSpace, Block, Expression, Function, Handle, LocalVariable, Module, ShaderStage,
    Statement,
};
use std::cell::RefCell;
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
    /// Variables whose values are being looked for: what one adds to itself hangs on nothing else.
    looking: RefCell<Vec<(usize, Handle<LocalVariable>)>>,
}

/// Every statement of a block, and of those in it.
fn every(block: &Block) -> Vec<&Statement> {
    let mut all = Vec::new();
    for statement in block {
        all.push(statement);
        match statement {
            Statement::If { accept, reject, .. } => {
                all.extend(every(accept));
                all.extend(every(reject));
            }
            Statement::Switch { cases, .. } => {
                all.extend(cases.iter().flat_map(|case| every(&case.body)));
            }
            Statement::Loop {
                body, continuing, ..
            } => {
                all.extend(every(body));
                all.extend(every(continuing));
            }
            Statement::Block(inner) => all.extend(every(inner)),
            _ => {}
        }
    }
    all
}

/// The values that a variable is given in a block, and the conditions under which it is.
fn stores(
    function: &Function,
    block: &Block,
    of: Handle<LocalVariable>,
) -> Vec<Handle<Expression>> {
    let mut all = Vec::new();
    for statement in block {
        let within = |blocks: &[&Block]| -> Vec<Handle<Expression>> {
            let parts = blocks.iter().map(|block| stores(function, block, of));
            parts.flatten().collect()
        };
        match statement {
            Statement::Store { pointer, value } => {
                all.extend((variable(function, *pointer) == Some(of)).then_some(*value));
            }
            Statement::If {
                condition,
                accept,
                reject,
            } => {
                let inner = within(&[accept, reject]);
                all.extend((!inner.is_empty()).then_some(*condition));
                all.extend(inner);
            }
            Statement::Switch { selector, cases } => {
                let bodies: Vec<&Block> = cases.iter().map(|case| &case.body).collect();
                let inner = within(&bodies);
                all.extend((!inner.is_empty()).then_some(*selector));
                all.extend(inner);
            }
            Statement::Loop {
                body, continuing, ..
            } => all.extend(within(&[body, continuing])),
            Statement::Block(inner) => all.extend(within(&[inner])),
            _ => {}
        }
    }
    all
}

/// The variable to which this points, whole or in part.
fn variable(function: &Function, pointer: Handle<Expression>) -> Option<Handle<LocalVariable>> {
    match &function.expressions[pointer] {
        Expression::LocalVariable(local) => Some(*local),
        Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => {
            variable(function, *base)
        }
        _ => None,
    }
}

impl Walk<'_> {
    /// What the values of a variable hang on, and the branches in which it is given them.
    fn of_variable(
        &self,
        function: &Function,
        given: &[Origin],
        of: Handle<LocalVariable>,
    ) -> Origin {
        let here = (std::ptr::from_ref(function).addr(), of);
        if self.looking.borrow().contains(&here) {
            return Origin::Constant;
        }
        self.looking.borrow_mut().push(here);
        let mut on = stores(function, &function.body, of);
        on.extend(function.local_variables[of].init);
        let origins = on
            .into_iter()
            .map(|value| self.origin(function, given, value));
        let origin = origins.max().unwrap_or(Origin::Constant);
        self.looking.borrow_mut().pop();
        origin
    }

    /// What the answer of a call hangs on.
    fn of_answer(&self, function: &Function, given: &[Origin], of: Handle<Expression>) -> Origin {
        let call = every(&function.body)
            .into_iter()
            .find_map(|statement| match statement {
                Statement::Call {
                    function: called,
                    arguments,
                    result,
                } if *result == Some(of) => Some((&self.module.functions[*called], arguments)),
                _ => None,
            });
        let Some((called, arguments)) = call else {
            return Origin::Pixel;
        };
        let given: Vec<Origin> = arguments
            .iter()
            .map(|argument| self.origin(function, given, *argument))
            .collect();
        let answers = every(&called.body)
            .into_iter()
            .filter_map(|statement| match statement {
                Statement::Return { value } => *value,
                _ => None,
            });
        let origins = answers.map(|value| self.origin(called, &given, value));
        origins.max().unwrap_or(Origin::Pixel)
    }

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
            E::LocalVariable(local) => self.of_variable(function, given, *local),
            E::CallResult(_) => self.of_answer(function, given, of),
            // Textures: taken for what differs.
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
        looking: RefCell::default(),
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
    // In the entry point's file, and where a function gives a loop its end.
    for (from, to, function) in [
        (
            "if t > 0.0 || beyond {",
            "if globe.apex_mm > 0.0 {",
            "fragment",
        ),
        (
            "i < LAMPS",
            "i < i32(illumination.exposure)",
            "through_cornea",
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
