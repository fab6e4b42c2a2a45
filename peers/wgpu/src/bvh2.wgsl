// The binary tree: two of `nodes` for each, the box with the number of triangles (0: an inner node)
// and the first triangle, or the first of two neighbouring children.

fn traverse(ray: ptr<function, Ray>) {
    // nodes, and where the ray enters them
    var stack: array<vec2u, STACK>;
    var waiting = 1u;
    stack[0] = vec2u(0u, bitcast<u32>((*ray).t_min));
    while waiting > 0u {
        waiting--;
        var node = stack[waiting].x;
        if bitcast<f32>(stack[waiting].y) > (*ray).t {
            continue;
        }
        var count = nodes[2u * node].w;
        while count == 0u {
            let first = nodes[2u * node + 1u].w;
            let left = enters(*ray, first);
            let right = enters(*ray, first + 1u);
            let is_right = right < left;
            if max(left, right) < NONE {
                stack[waiting] = vec2u(first + u32(!is_right), bitcast<u32>(max(left, right)));
                waiting++;
            }
            if min(left, right) == NONE {
                break;
            }
            node = first + u32(is_right);
            count = nodes[2u * node].w;
        }
        let first = nodes[2u * node + 1u].w;
        for (var i = first; i < first + count; i++) {
            if test(ray, i) && ANY_HIT {
                return;
            }
        }
    }
}

// Where a ray enters the box of a node, or NONE.
fn enters(ray: Ray, node: u32) -> f32 {
    let low = bitcast<vec3f>(nodes[2u * node].xyz) - ray.origin;
    let high = bitcast<vec3f>(nodes[2u * node + 1u].xyz) - ray.origin;
    let pad = padding(ray, max(abs(low), abs(high)));
    let near = min(low * ray.inverse, high * ray.inverse) - pad;
    let far = max(low * ray.inverse, high * ray.inverse) + pad;
    let begin = max(max(near.x, near.y), max(near.z, ray.t_min));
    return select(NONE, begin, begin <= min(min(far.x, far.y), min(far.z, ray.t)));
}
