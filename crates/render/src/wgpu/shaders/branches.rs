//! No branch and no loop of a shader that runs each frame depends on uniforms alone.
//!
//! Mesa's software driver compiles a shader again for every value of such a uniform, and looks it up at every draw. A
//! frame then takes seconds, or still twice its time if a cache on disk has each variant.

use wgpu::naga::{AddressSpace, Block, Expression, Function, Handle, Module, Statement, front::wgsl};

use super::compiled::{all, statements};

/// Source of a value in a shader. A value that depends on several sources has the last one in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Origin {
    Constants,
    Uniforms,
    /// A value that differs between invocations, or may.
    Invocation,
}

/// Function, with the sources of its arguments at one call.
struct Call<'a> {
    module: &'a Module,
    function: &'a Function,
    arguments: Vec<Origin>,
}

impl Call<'_> {
    fn origin(&self, handle: Handle<Expression>) -> Origin {
        let of =
            |handles: &[Handle<Expression>]| handles.iter().map(|&h| self.origin(h)).max().unwrap_or(Origin::Constants);
        match &self.function.expressions[handle] {
            Expression::Literal(_) | Expression::Constant(_) | Expression::ZeroValue(_) => Origin::Constants,
            Expression::GlobalVariable(variable) => match self.module.global_variables[*variable].space {
                AddressSpace::Uniform => Origin::Uniforms,
                _ => Origin::Invocation,
            },
            Expression::FunctionArgument(index) => self.arguments[*index as usize],
            Expression::Load { pointer: inner }
            | Expression::AccessIndex { base: inner, .. }
            | Expression::Unary { expr: inner, .. }
            | Expression::As { expr: inner, .. }
            | Expression::Splat { value: inner, .. }
            | Expression::Swizzle { vector: inner, .. }
            | Expression::Relational { argument: inner, .. } => of(&[*inner]),
            Expression::Access { base: left, index: right } | Expression::Binary { left, right, .. } => {
                of(&[*left, *right])
            }
            Expression::Select { condition, accept, reject } => of(&[*condition, *accept, *reject]),
            Expression::Compose { components, .. } => of(components),
            Expression::Math { arg, arg1, arg2, arg3, .. } => {
                of(&[Some(*arg), *arg1, *arg2, *arg3].into_iter().flatten().collect::<Vec<_>>())
            }
            _ => Origin::Invocation,
        }
    }

    /// True if an `if` depends on uniforms alone, or ends a loop by comparison with a uniform.
    fn hangs_on_uniforms(&self, condition: Handle<Expression>, accept: &Block, reject: &Block) -> bool {
        let breaks = |block: &Block| block.iter().any(|statement| matches!(statement, Statement::Break));
        let ends_loop = breaks(accept) || breaks(reject);
        let bound = match &self.function.expressions[condition] {
            Expression::Binary { left, right, .. } => [*left, *right].map(|side| self.origin(side)),
            _ => [Origin::Constants; 2],
        };
        self.origin(condition) == Origin::Uniforms || (ends_loop && bound.contains(&Origin::Uniforms))
    }

    /// Collects the names of this function and of all functions it calls that contain such an `if`.
    fn findings(&self, block: &Block, found: &mut Vec<String>) {
        for statement in statements(block) {
            match statement {
                Statement::If { condition, accept, reject } if self.hangs_on_uniforms(*condition, accept, reject) => {
                    found.push(self.function.name.clone().unwrap_or_default());
                }
                Statement::Call { function, arguments, .. } => {
                    let arguments = arguments.iter().map(|&argument| self.origin(argument)).collect();
                    let function = &self.module.functions[*function];
                    Call { module: self.module, function, arguments }.findings(&function.body, found);
                }
                _ => {}
            }
        }
    }
}

fn findings(wgsl: &str) -> Vec<String> {
    let module = wgsl::parse_str(wgsl).expect("another test parses them all");
    let mut found = Vec::new();
    for entry in &module.entry_points {
        let function = &entry.function;
        let arguments = vec![Origin::Invocation; function.arguments.len()];
        Call { module: &module, function, arguments }.findings(&function.body, &mut found);
    }
    found
}

#[test]
fn no_branch_hangs_on_uniforms_alone() {
    // Points are located once per call, not in every frame.
    for (name, wgsl) in all().iter().filter(|(name, _)| *name != "locate") {
        assert_eq!(findings(wgsl), Vec::<String>::new(), "{name}");
    }
    let planted = |statements: &str| {
        findings(&format!(
            "struct Light {{ count: u32, hard: f32 }} @group(0) @binding(0) var<uniform> light: Light;
            fn shade(hard: bool) -> f32 {{ if hard {{ return 1.0; }} return 0.5; }}
            @fragment fn main(@location(0) x: f32) -> @location(0) vec4f {{ var y = x; {statements} return vec4f(y); }}"
        ))
    };
    assert_eq!(planted("if light.hard == 0.0 { y = 1.0; }").len(), 1);
    assert_eq!(planted("y = shade(light.hard == 0.0);"), ["shade"]);
    assert_eq!(planted("for (var i = 0u; i < light.count; i++) { y *= 2.0; }").len(), 1);
    assert_eq!(planted("y = select(x, 1.0, light.hard == 0.0); if x < light.hard { y = 2.0; }").len(), 0);
    assert_eq!(
        planted("let end = select(0u, light.count, x > 0.0); for (var i = 0u; i < end; i++) { y *= 2.0; }").len(),
        0
    );
}
