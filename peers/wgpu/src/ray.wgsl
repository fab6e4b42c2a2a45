// What both traversals share. Constants: ANY_HIT; WATERTIGHT; PADDING, the widening of boxes in parts
// of their distance; STACK; FAULT, a planted mistake: 1 loses hits on edges, 2 those of every eighth
// triangle.

// Two of these a ray: origin and t_min, direction and t_max.
@group(0) @binding(0) var<storage, read> rays: array<vec4u>;
// Three a triangle: the corners. Their last words: id, 1 where shadow rays pass, 0.
@group(0) @binding(1) var<storage, read> triangles: array<vec4u>;
@group(0) @binding(2) var<storage, read> nodes: array<vec4u>;
// Closest hits: t and id of each ray. Occlusion: 1 or 0 for each.
@group(0) @binding(3) var<storage, read_write> answers: array<u32>;

const MISS = 0xffffffffu;
// Greater than every t; WGSL knows no infinity.
const NONE = 3.4028234e38;
// Smaller components of a direction are zero to boxes.
const LEAST = vec3f(8.6736174e-19);

// A ray, scaled by a power of two so that the largest component of its direction is in [1, 2).
struct Ray {
    origin: vec3f,
    direction: vec3f,
    inverse: vec3f,
    t_min: f32,
    // the best hit so far, or the end of the interval
    t: f32,
    id: u32,
    // the axis of the largest component, and Woop's shear
    axis: u32,
    shear: vec3f,
    // a zero that no compiler knows
    zero: u32,
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) place: vec3u) {
    let index = place.x;
    if 2u * index >= arrayLength(&rays) {
        return;
    }
    let first = rays[2u * index];
    let second = rays[2u * index + 1u];
    var ray: Ray;
    ray.origin = bitcast<vec3f>(first.xyz);
    let sizes = second.xyz & vec3u(0x7fffffffu);
    let exponent = clamp(max(sizes.x, max(sizes.y, sizes.z)) >> 23u, 1u, 253u);
    let up = bitcast<f32>((254u - exponent) << 23u);
    let down = bitcast<f32>(exponent << 23u);
    let d = bitcast<vec3f>(second.xyz) * up;
    ray.direction = d;
    ray.inverse = 1.0 / select(d, select(LEAST, -LEAST, d < vec3f()), abs(d) < LEAST);
    ray.t_min = bitcast<f32>(first.w) * down;
    let end = bitcast<f32>(select(second.w, 0x7f7fffffu, second.w == 0x7f800000u));
    ray.t = min(end, 0.5 * NONE * min(up, 1.0)) * down;
    ray.id = MISS;
    let size = abs(d);
    ray.axis = select(select(2u, 1u, size.y >= size.z), 0u, size.x >= max(size.y, size.z));
    let turned = turn(ray, d);
    ray.shear = vec3f(turned.xy / turned.z, 1.0 / turned.z);
    traverse(&ray);
    if ANY_HIT {
        answers[index] = u32(ray.id != MISS);
    } else {
        answers[2u * index] = bitcast<u32>(ray.t * up);
        answers[2u * index + 1u] = ray.id;
    }
}

// The axis of the largest component of the direction last.
fn turn(ray: Ray, v: vec3f) -> vec3f {
    return select(select(v, v.zxy, ray.axis == 1u), v.yzx, ray.axis == 0u);
}

// Takes the hit of a triangle if it is nearer; of equal ones that with the lower id. True if so.
fn test(ray: ptr<function, Ray>, index: u32) -> bool {
    let first = triangles[3u * index];
    let second = triangles[3u * index + 1u];
    let third = triangles[3u * index + 2u];
    let id = first.w;
    (*ray).zero = third.w;
    if (ANY_HIT && second.w != 0u) || (FAULT == 2 && id % 8u == 0u) {
        return false;
    }
    let a = bitcast<vec3f>(first.xyz) - (*ray).origin;
    let b = bitcast<vec3f>(second.xyz) - (*ray).origin;
    let c = bitcast<vec3f>(third.xyz) - (*ray).origin;
    var t = NONE;
    if WATERTIGHT {
        t = watertight(*ray, a, b, c);
    } else {
        t = moeller_trumbore((*ray).direction, a, b, c);
    }
    if !(t >= (*ray).t_min && (t < (*ray).t || (t == (*ray).t && id < (*ray).id))) {
        return false;
    }
    (*ray).t = t;
    (*ray).id = id;
    return true;
}

// Woop, Benthin and Wald 2013, of both sides; corners are relative to the origin.
fn watertight(ray: Ray, a: vec3f, b: vec3f, c: vec3f) -> f32 {
    let ta = turn(ray, a);
    let tb = turn(ray, b);
    let tc = turn(ray, c);
    let pa = sheared(ray, ta);
    let pb = sheared(ray, tb);
    let pc = sheared(ray, tc);
    let e = vec3f(edge(ray, pc, pb), edge(ray, pa, pc), edge(ray, pb, pa));
    let determinant = e.x + e.y + e.z;
    let is_outside = any(e < vec3f()) && any(e > vec3f());
    if is_outside || determinant == 0.0 || (FAULT == 1 && any(e == vec3f())) {
        return NONE;
    }
    return dot(e, vec3f(ta.z, tb.z, tc.z)) * ray.shear.z / determinant;
}

fn sheared(ray: Ray, v: vec3f) -> vec2f {
    return vec2f(v.x - product(ray, ray.shear.x, v.z), v.y - product(ray, ray.shear.y, v.z));
}

// a * b, rounded: WGSL allows to fuse a product with a sum, and the zero hides it from whoever would.
// Two triangles then compute the same number for the edge that they share, but for its sign.
fn product(ray: Ray, a: f32, b: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(a * b) ^ ray.zero);
}

// p.x * q.y - p.y * q.x, with the sign that it has without rounding.
fn edge(ray: Ray, p: vec2f, q: vec2f) -> f32 {
    let a = product(ray, p.x, q.y);
    let b = product(ray, p.y, q.x);
    if a != b || a == 0.0 {
        return a - b;
    }
    // Both round to one number. Woop et al. compute in double there, which WGSL lacks: these are whole
    // numbers, of 48 bits, and exact. Exponents differ by two at most.
    let bits = bitcast<vec4u>(vec4f(p.x, q.y, p.y, q.x));
    let exponents = vec4i((bits >> vec4u(23u)) & vec4u(255u));
    let digits = (bits & vec4u(0x7fffffu)) | vec4u(0x800000u);
    let of_a = exponents.x + exponents.y;
    let of_b = exponents.z + exponents.w;
    let wide_a = wide_product(digits.x, digits.y) << vec2u(u32(max(of_a - of_b, 0)));
    let wide_b = wide_product(digits.z, digits.w) << vec2u(u32(max(of_b - of_a, 0)));
    let parts = vec2i(wide_a) - vec2i(wide_b);
    let difference = f32(parts.x * 16777216 + parts.y);
    // in two steps, as a power of two may be too small for a number
    let exponent = min(of_a, of_b) - 300;
    return ldexp(ldexp(difference, exponent / 2), exponent - exponent / 2) * sign(a);
}

// The product of two numbers of 24 bits: its upper and lower 24.
fn wide_product(a: u32, b: u32) -> vec2u {
    let upper = vec2u(a, b) >> vec2u(12u);
    let lower = vec2u(a, b) & vec2u(4095u);
    let middle = upper.x * lower.y + lower.x * upper.y;
    let rest = lower.x * lower.y + ((middle & 4095u) << 12u);
    return vec2u(upper.x * upper.y + (middle >> 12u) + (rest >> 24u), rest & 0xffffffu);
}

fn moeller_trumbore(direction: vec3f, a: vec3f, b: vec3f, c: vec3f) -> f32 {
    let p = cross(direction, c - a);
    let q = cross(b - a, a);
    let determinant = dot(b - a, p);
    let u = -dot(a, p) / determinant;
    let v = dot(direction, q) / determinant;
    let is_inside = determinant != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0;
    return select(NONE, dot(c - a, q) / determinant, is_inside);
}

// Widening of the distances of a box's planes; its corners are at most so far from the origin.
fn padding(ray: Ray, reach: vec3f) -> vec3f {
    return PADDING * max(reach.x, max(reach.y, reach.z)) * abs(ray.inverse);
}
