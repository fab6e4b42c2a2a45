// The compressed eight-wide tree of Ylitie, Karras and Laine 2017 as obvhs lays it out, five of
// `nodes` each. A group is a base index and bits: nodes to visit in the upper eight, beside the mask
// of inner nodes in the lower eight.

fn traverse(ray: ptr<function, Ray>) {
    var stack: array<vec2u, STACK>;
    var waiting = 0u;
    let is_forward = (*ray).direction >= vec3f();
    let octant = dot(select(vec3u(), vec3u(4u, 2u, 1u), is_forward), vec3u(1u)) * 0x01010101u;
    var group = vec2u(0u, 0x80000000u);
    loop {
        let bits = group.y;
        let bit = firstLeadingBit(bits);
        group.y ^= 1u << bit;
        if group.y > 0xffffffu {
            stack[waiting] = group;
            waiting++;
        }
        let slot = (bit - 24u) ^ (octant & 7u);
        let node = 5u * (group.x + countOneBits(bits & ((1u << slot) - 1u)));
        let bases = nodes[node + 1u].xy;
        let hits = children(*ray, node, octant);
        group = vec2u(bases.x, (hits & 0xff000000u) | (nodes[node].w >> 24u));
        var found = hits & 0xffffffu;
        while found != 0u {
            let at = firstLeadingBit(found);
            found ^= 1u << at;
            if test(ray, bases.y + at) && ANY_HIT {
                return;
            }
        }
        if group.y <= 0xffffffu {
            if waiting == 0u {
                return;
            }
            waiting--;
            group = stack[waiting];
        }
    }
}

// Bits of the children whose boxes a ray enters: nodes in the order of visit from 24 on, triangles
// below.
fn children(ray: Ray, node: u32, octant: u32) -> u32 {
    let first = nodes[node];
    let exponents = (vec3u(first.w) >> vec3u(0u, 8u, 16u)) & vec3u(255u);
    let unit = bitcast<vec3f>(exponents << vec3u(23u));
    let corner = bitcast<vec3f>(first.xyz) - ray.origin;
    let pad = padding(ray, max(abs(corner), abs(corner + 255.0 * unit)));
    let step = unit * ray.inverse;
    let near_at = corner * ray.inverse - pad;
    let far_at = corner * ray.inverse + pad;
    let is_back = ray.direction < vec3f();
    var hits = 0u;
    for (var half = 0u; half < 2u; half++) {
        // four children; nodes have bits 3 and 4, triangles never both
        let kinds = nodes[node + 1u][2u + half];
        let inner = ((kinds & (kinds << 1u)) & 0x10101010u) >> 4u;
        let places = (kinds ^ (octant & (inner * 255u))) & 0x1f1f1f1fu;
        let marks = (kinds >> 5u) & 0x07070707u;
        let low = vec3u(nodes[node + 2u][half], nodes[node + 3u][half], nodes[node + 4u][half]);
        let high = vec3u(
            nodes[node + 2u][2u + half], nodes[node + 3u][2u + half], nodes[node + 4u][2u + half]);
        let near = select(low, high, is_back);
        let far = select(high, low, is_back);
        let begin = max(
            max(planes(near.x) * step.x + near_at.x, planes(near.y) * step.y + near_at.y),
            max(planes(near.z) * step.z + near_at.z, vec4f(ray.t_min)));
        let end = min(
            min(planes(far.x) * step.x + far_at.x, planes(far.y) * step.y + far_at.y),
            min(planes(far.z) * step.z + far_at.z, vec4f(ray.t)));
        for (var i = 0u; i < 4u; i++) {
            let mark = ((marks >> (8u * i)) & 255u) << ((places >> (8u * i)) & 255u);
            hits |= select(0u, mark, begin[i] <= end[i]);
        }
    }
    return hits;
}

// Four planes of a byte each.
fn planes(bytes: u32) -> vec4f {
    return vec4f((vec4u(bytes) >> vec4u(0u, 8u, 16u, 24u)) & vec4u(255u));
}
