// Computes the increasing roots of one point on one curve each, for `bendylights bench solver`. Follows solve.wgsl.

@group(0) @binding(0) var<storage, read> curves: array<Curve>;
@group(0) @binding(1) var<storage, read> points: array<vec4f>;
// The left root and the right one, then 1 for each that exists.
@group(0) @binding(2) var<storage, read_write> found: array<vec4f>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    if i >= arrayLength(&points) {
        return;
    }
    let c = curves[i];
    let q = points[i].xyz;
    let roots = increasing_roots(c, q, -dot(q - c.b0, c.d0), -dot(q - c.b2, c.d1));
    found[i] = vec4f(roots.left, roots.right, f32(roots.has_left), f32(roots.has_right));
}
