"""Touching features of two solids: the whole set within a reach, each place once.

Which features can touch with the normal n (from b to a) is a local question: all neighbours of a vertex and
both faces of an edge must lie on their own body's side of the plane across n.  That holds for convex and
non-convex solids alike (for convex ones it makes the plane separate them as a whole).  Special positions
come out of the same test: an edge on a face touches at its ends and where it crosses the border, parallel
edges at the ends of what they share, coplanar faces at the corners of their common polygon.

Contacts of two normals at one place are both needed in a notch; on a ridge one of them is enough, because its
plane alone separates all that is there.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.collide.features import EDGES, FACE, LINE, POINT
from reference_impl.collide.primitives import put
from reference_impl.collide.solids import CONCAVE_EDGE, halves
from reference_impl.kernels import along, apply, apply_transposed, cross, dot, kernel, minus, norm

PARALLEL = 1e-8  # sine of an angle that counts as none
SAME_PLACE = 10.0  # [lateral]
SAME_NORMAL = 1e-12  # one less the cosine


@kernel
def near_cells(sa, sb, xa, ra, xb, rb, reach, out):
    """Pairs of cells whose balls come within `reach` of each other (radii apart), into `out`; returns how many.

    More than `out` has rows for are counted but not written.
    """
    count, top = 0, 1
    stack = np.empty((512, 2), dtype=np.int64)
    stack[0, 0] = stack[0, 1] = 0
    limit = reach + sa.radius + sb.radius
    while top > 0:
        top -= 1
        i, j = stack[top, 0], stack[top, 1]
        pa, pb = apply(ra, sa.ball[i, :3]), apply(rb, sb.ball[j, :3])
        square = 0.0
        for c in range(3):
            square += (xa[c] - xb[c] + pa[c] - pb[c]) ** 2
        if math.sqrt(square) - sa.ball[i, 3] - sb.ball[j, 3] > limit:
            continue
        if sa.child[i, 0] < 0 and sb.child[j, 0] < 0:
            if count < len(out):
                out[count, 0], out[count, 1] = sa.child[i, 1], sb.child[j, 1]
            count += 1
        else:
            top = halves(stack, top, i, j, sa.child, sa.ball, sb.child, sb.ball)
    return count


@kernel
def solid_solid(a, b, sa, xa, ra, sb, xb, rb, reach, deep, lateral, cells, kinds, reals, enough, points, normals):
    """Contacts of two solids with a gap from -`deep` to `reach`; returns their number.

    Parameters
    ----------
    cells : (k, 2) array
        Pairs of cells that are near, from `near_cells`.
    kinds, reals, enough, points, normals : arrays, written
        Contacts, whether the plane of each alone separates the bodies there, point and gap (4,), normal from b to a.
    """
    count = 0
    for k in range(len(cells)):
        i, j = cells[k, 0], cells[k, 1]
        for c in range(3):
            args = (reach, deep, lateral, kinds, reals, enough, points, normals)
            count = _vertex_face(a, b, sa, sa.cells[i, c], xa, ra, sb, j, xb, rb, 1.0, count, *args)
            count = _vertex_face(b, a, sb, sb.cells[j, c], xb, rb, sa, i, xa, ra, -1.0, count, *args)
    for inner in range(2):  # crossings that end at a corner count only where nothing else was found
        for k in range(len(cells)):
            i, j = cells[k, 0], cells[k, 1]
            for c in range(3):
                for d in range(3):
                    e, f = sa.cell_edges[i, c], sb.cell_edges[j, d]
                    if e >= 0 and f >= 0:
                        margin = lateral if inner == 0 else -lateral
                        count = _edge_edge(a, b, sa, e, xa, ra, sb, f, xb, rb, margin, count, *args)
    if sa.radius + sb.radius > 0.0:
        for k in range(len(cells)):
            i, j = cells[k, 0], cells[k, 1]
            for c in range(3):
                for d in range(3):
                    if sb.cell_edges[j, d] >= 0:
                        count = _vertex_edge(
                            a, b, sa, sa.cells[i, c], xa, ra, sb, sb.cell_edges[j, d], xb, rb, 1.0, count, *args
                        )
                    if sa.cell_edges[i, d] >= 0:
                        count = _vertex_edge(
                            b, a, sb, sb.cells[j, c], xb, rb, sa, sa.cell_edges[i, d], xa, ra, -1.0, count, *args
                        )
        for k in range(len(cells)):
            for c in range(3):
                for d in range(3):
                    i, j = sa.cells[cells[k, 0], c], sb.cells[cells[k, 1], d]
                    count = _vertex_vertex(a, b, sa, i, xa, ra, sb, j, xb, rb, count, *args)
    return count


@kernel
def _known(count, kinds, first, kind, fa, fb):
    for k in range(count):
        if kinds[k, 0] == first and kinds[k, 2] == kind and kinds[k, 3] == fa and kinds[k, 4] == fb:
            return True
    return False


@kernel
def _leans(solid, i, rotation, n, sign):
    """Whether a neighbour of vertex i lies beyond the plane across `sign` n through it."""
    local = apply_transposed(rotation, n)
    for k in range(solid.star_start[i], solid.star_start[i + 1]):
        if sign * dot(solid.star[k], local) < -PARALLEL:
            return True
    return False


@kernel
def _edge_leans(solid, e, rotation, n, sign):
    """Whether a face at edge e lies beyond the plane across `sign` n through it."""
    local = apply_transposed(rotation, n)
    return sign * dot(solid.sides[e, 0], local) < -PARALLEL or sign * dot(solid.sides[e, 1], local) < -PARALLEL


@kernel
def _add(count, kinds, reals, enough, points, normals, point, n, gap, alone, lateral):
    """Keep row `count` unless another contact of the same place makes it superfluous; returns the new count.

    Of two that are enough alone the one with the greater gap stays: that much room there is.
    """
    place, at = SAME_PLACE * lateral, count
    for k in range(count):
        if abs(points[k, 0] - point[0]) + abs(points[k, 1] - point[1]) + abs(points[k, 2] - point[2]) > place:
            continue
        cosine = normals[k, 0] * n[0] + normals[k, 1] * n[1] + normals[k, 2] * n[2]
        if cosine > 1.0 - SAME_NORMAL:
            return count
        if alone and (not enough[k] or gap > points[k, 3] + 1e-3 * lateral):
            at = k
        elif enough[k]:
            return count
    for c in range(kinds.shape[1]):
        kinds[at, c] = kinds[count, c]
    for c in range(reals.shape[1]):
        reals[at, c] = reals[count, c]
    enough[at], points[at, 3] = alone, gap
    for c in range(3):
        points[at, c], normals[at, c] = point[c], n[c]
    return count + 1 if at == count else count


@kernel
def _vertex_face(
    p, q, sp, i, xp, rp, sq, cell, xq, rq, sign, count, reach, deep, lateral, kinds, reals, enough, points, normals
):
    """Vertex i of solid p on the face that triangle `cell` of solid q belongs to; n goes from q to p, times `sign`."""
    face = sq.cell_face[cell]
    if face < 0 or not sp.sharp[i] or count >= len(kinds) or _known(count, kinds, p, FACE, i, face):
        return count
    arm = apply(rp, sp.points[i])
    world = np.empty(3)
    for c in range(3):
        world[c] = xp[c] - xq[c] + arm[c]
    local = apply_transposed(rq, world)
    normal = sq.normals[face]
    gap = -sp.radius
    for c in range(3):
        gap += normal[c] * (local[c] - sq.bases[face, c])
    if gap > reach or gap < -deep:
        return count
    alone = True
    for k in range(3):
        u, w = sq.points[sq.cells[cell, k]], sq.points[sq.cells[cell, (k + 1) % 3]]
        way = minus(w, u)
        size = norm(way)
        off = minus(local, u)
        out = dot(cross(way, normal), off) / size  # beyond the triangle's edge
        if out > lateral:
            return count
        if abs(out) <= SAME_PLACE * lateral and sq.cell_edges[cell, k] == CONCAVE_EDGE:
            alone = False
    n = apply(rq, normal)
    if _leans(sp, i, rp, n, 1.0):
        return count
    for k in range(3):
        j = sq.cells[cell, k]
        off = minus(local, sq.points[j])
        if norm(off) <= SAME_PLACE * lateral + abs(gap + sp.radius) and _leans(sq, j, rq, n, -1.0):
            alone = False
    point = np.empty(3)
    for c in range(3):
        point[c] = xp[c] + arm[c] - sp.radius * n[c]
        n[c] *= sign
    put(kinds, reals, count, p, q, FACE, i, face)
    for c in range(3):
        reals[count, c] = sp.points[i, c]
        reals[count, 6 + c] = sq.bases[face, c]
        reals[count, 9 + c] = normal[c]
    reals[count, 12] = reals[count, 13] = sp.radius
    return _add(count, kinds, reals, enough, points, normals, point, n, gap, alone, lateral)


@kernel
def _edge_edge(
    a, b, sa, e, xa, ra, sb, f, xb, rb, margin, count, reach, deep, lateral, kinds, reals, enough, points, normals
):
    """Edge e of a crossing edge f of b, at least `margin` inside both."""
    if count >= len(kinds) or _known(count, kinds, a, EDGES, e, f):
        return count
    u, w = apply(ra, sa.ways[e]), apply(rb, sb.ways[f])
    n = cross(u, w)
    square = dot(n, n)
    if square < PARALLEL * PARALLEL:
        return count
    arm_a, arm_b = apply(ra, sa.middles[e]), apply(rb, sb.middles[f])
    r = np.empty(3)
    for c in range(3):
        r[c] = xa[c] - xb[c] + arm_a[c] - arm_b[c]
    s = -dot(cross(w, n), r) / square
    t = dot(cross(n, u), r) / square
    if abs(s) > sa.halves[e] - margin or abs(t) > sb.halves[f] - margin:
        return count
    outward = dot(apply(ra, sa.sides[e, 0]), n) + dot(apply(ra, sa.sides[e, 1]), n)
    outward -= dot(apply(rb, sb.sides[f, 0]), n) + dot(apply(rb, sb.sides[f, 1]), n)
    if outward == 0.0:  # two segments: nothing but their places tells the sides
        outward = dot(n, r)
    turn = (1.0 if outward > 0.0 else -1.0) / math.sqrt(square)
    for c in range(3):
        n[c] *= turn
    radii = sa.radius + sb.radius
    gap = dot(n, r) - radii
    if gap > reach or gap < -deep or _edge_leans(sa, e, ra, n, 1.0) or _edge_leans(sb, f, rb, n, -1.0):
        return count
    point = np.empty(3)
    for c in range(3):
        point[c] = xb[c] + arm_b[c] + t * w[c] + sb.radius * n[c]
    put(kinds, reals, count, a, b, EDGES, e, f)
    for c in range(3):
        reals[count, c] = sa.middles[e, c]
        reals[count, 3 + c] = sa.ways[e, c]
        reals[count, 6 + c] = sb.middles[f, c]
        reals[count, 9 + c] = sb.ways[f, c] if turn > 0.0 else -sb.ways[f, c]
    reals[count, 12], reals[count, 13] = radii, sa.radius
    return _add(count, kinds, reals, enough, points, normals, point, n, gap, True, lateral)


@kernel
def _vertex_edge(
    p, q, sp, i, xp, rp, sq, f, xq, rq, sign, count, reach, deep, lateral, kinds, reals, enough, points, normals
):
    """Vertex i of p at edge f of q, where radii keep them apart."""
    if not sp.sharp[i] or count >= len(kinds) or _known(count, kinds, p, LINE, i, f):
        return count
    way = apply(rq, sq.ways[f])
    arm, middle = apply(rp, sp.points[i]), apply(rq, sq.middles[f])
    m = np.empty(3)
    for c in range(3):
        m[c] = xp[c] - xq[c] + arm[c] - middle[c]
    s = dot(m, way)
    for c in range(3):
        m[c] -= s * way[c]
    distance, radii = norm(m), sp.radius + sq.radius
    if abs(s) > sq.halves[f] + lateral or distance == 0.0 or distance - radii > reach or distance - radii < -deep:
        return count
    n, point = np.empty(3), np.empty(3)
    for c in range(3):
        n[c] = m[c] / distance
        point[c] = xp[c] + arm[c] - sp.radius * n[c]
    if _edge_leans(sq, f, rq, n, -1.0) or _leans(sp, i, rp, n, 1.0):
        return count
    put(kinds, reals, count, p, q, LINE, i, f)
    for c in range(3):
        n[c] *= sign
        reals[count, c] = sp.points[i, c]
        reals[count, 6 + c] = sq.middles[f, c]
        reals[count, 9 + c] = sq.ways[f, c]
    reals[count, 12], reals[count, 13] = radii, sp.radius
    return _add(count, kinds, reals, enough, points, normals, point, n, distance - radii, True, lateral)


@kernel
def _vertex_vertex(
    a, b, sa, i, xa, ra, sb, j, xb, rb, count, reach, deep, lateral, kinds, reals, enough, points, normals
):
    """Vertex i of a at vertex j of b, where radii keep them apart."""
    if not (sa.sharp[i] and sb.sharp[j]) or count >= len(kinds) or _known(count, kinds, a, POINT, i, j):
        return count
    arm_a, arm_b = apply(ra, sa.points[i]), apply(rb, sb.points[j])
    n, point = np.empty(3), np.empty(3)
    for c in range(3):
        n[c] = xa[c] - xb[c] + arm_a[c] - arm_b[c]
    distance, radii = norm(n), sa.radius + sb.radius
    if distance == 0.0 or distance - radii > reach or distance - radii < -deep:
        return count
    for c in range(3):
        n[c] /= distance
        point[c] = xa[c] + arm_a[c] - sa.radius * n[c]
    if _leans(sa, i, ra, n, 1.0) or _leans(sb, j, rb, n, -1.0):
        return count
    put(kinds, reals, count, a, b, POINT, i, j)
    for c in range(3):
        reals[count, c] = sa.points[i, c]
        reals[count, 6 + c] = sb.points[j, c]
    reals[count, 12], reals[count, 13] = radii, sa.radius
    return _add(count, kinds, reals, enough, points, normals, point, n, distance - radii, True, lateral)


@kernel
def solid_margin(kinds, reals, sp, xp, rp, sq, xq, rq):
    """How far inside its features a contact of solids p and q (in the contact's order) lies [m].

    Negative once the features no longer face each other.
    """
    kind, i, f = kinds[2], kinds[3], kinds[4]
    arm_p, arm_q = apply(rp, reals[0:3]), apply(rq, reals[6:9])
    r = np.empty(3)
    for c in range(3):
        r[c] = xp[c] - xq[c] + arm_p[c] - arm_q[c]
    if kind == FACE:
        return _inside_border(sq, f, along(apply_transposed(rq, r), 1.0, sq.bases[f]))
    if kind == EDGES:
        u, w = apply(rp, reals[3:6]), apply(rq, reals[9:12])
        n = cross(u, w)
        square = dot(n, n)
        s, t = -dot(cross(w, n), r) / square, dot(cross(n, u), r) / square
        return min(sp.halves[i] - abs(s), sq.halves[f] - abs(t))
    out = np.inf
    if kind == LINE:
        w = apply(rq, reals[9:12])
        s = dot(r, w)
        for c in range(3):
            r[c] -= s * w[c]
        local = apply_transposed(rq, r)
        out = min(sq.halves[f] - abs(s), -dot(sq.sides[f, 0], local), -dot(sq.sides[f, 1], local))
        if not sq.sides[f].any():
            out = sq.halves[f] - abs(s)
    else:
        local = apply_transposed(rq, r)
        for k in range(sq.star_start[f], sq.star_start[f + 1]):
            out = min(out, -dot(sq.star[k], local))
    local = apply_transposed(rp, r)
    for k in range(sp.star_start[i], sp.star_start[i + 1]):
        out = min(out, dot(sp.star[k], local))
    return out


@kernel
def _inside_border(solid, face, point):
    """Distance of a point over a face from the face's border [m]; negative outside."""
    n = solid.normals[face]
    least, turns = np.inf, 0.0
    for k in range(solid.border_start[face], solid.border_start[face + 1]):
        a, b = minus(point, solid.border[k, 0]), minus(point, solid.border[k, 1])
        way = minus(a, b)
        part = min(max(dot(a, way) / dot(way, way), 0.0), 1.0)
        foot = along(a, -part, way)
        height = dot(foot, n)
        least = min(least, math.sqrt(max(dot(foot, foot) - height * height, 0.0)))
        ha, hb = dot(a, n), dot(b, n)
        a, b = along(a, -ha, n), along(b, -hb, n)
        turns += math.atan2(dot(cross(a, b), n), dot(a, b))  # 2 pi in all around an inner point
    return least if abs(turns) > math.pi else -least
