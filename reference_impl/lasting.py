"""Motion in lasting contact: accelerations under contact forces, carried on by Runge-Kutta steps.

Every island goes its own way (`course`).  Its step ends early where a contact slides off the edge of its feature or
ceases to slide; a body that arrives from elsewhere interrupts it.  What interrupts is searched on polynomials, and
then the motion itself is carried there: if it is not where its polynomials had it, they are laid anew up to that
time and the search goes on, so that no island ever has to go back behind what others have done already.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.collide.detect import Contacts, kinematics, rotations
from reference_impl.contact_problem import NoSolution
from reference_impl.course import Course
from reference_impl.effects.resting import Pose, Push
from reference_impl.errors import Stalled
from reference_impl.rough import jam
from reference_impl.segments import where
from reference_impl.world import World

DEEP = 10.0  # overlap that sends a step back: what counts as touching by the tolerance alone [search tolerance]
FINEST = 1e-12  # tolerance below which that overlap shrinks no further, to stay above rounding [smallest body size]
SHORTEST = 1e-13  # step below which the motion is stuck [time scale]
BRINK = 1e-7  # time before forces cease to exist at which impulses take over [time scale]
SHORT = 1e-3  # of a step, that is left for another one where a slip that turns comes to its end
STANDING = 1e-15  # slip at which a contact has stopped [speed scale]
ULPS = 1e-15  # change of a gap that is the rounding of the coordinates
LOST = 4  # implicit steps towards the end of a slip that are not found, before one ends where the last was
CUTS = 60  # of one step, before the polynomials are taken for the motion
LOOKS = 16  # within one step, for contacts that leave their features and return
BEYOND = 0.01  # how far past a meeting polynomials are laid anew, which makes them 1e6 times as good there [step]


def embark(world: World, limit: float) -> None:
    """Give every island that has none its next step, at most to `limit` [s].

    Raises
    ------
    Stalled
        If no step is short enough, or the contacts allow no motion.
    """
    for course in world.courses:
        if course.end == -math.inf and not world.dirty[course.members].any():
            try:
                _step(world, course, limit)
            except NoSolution as error:
                raise Stalled(f"resting contact: {error}", world.t) from None


def _step(world: World, course: Course, limit: float) -> None:
    start, y = course.begin, course.y
    scale = course.scale()
    h = float(world.pace[course.members].min())
    first: np.ndarray | None = None
    while True:
        if h < SHORTEST * world.scales.time:
            names = ", ".join(world.names(*course.members))
            raise Stalled(f"lasting contact of {names}: step below {h:.3g} s", start)
        end = min(start + h, limit)
        try:
            if first is None:
                first = course(start, y)
                pressing = course.push.force
            course.choose(end - start, first, pressing)
            new, stages = course.method.step(course, start, y, end - start, first)
            error = course.method.error(stages, end - start, scale)
            if error <= 1.0 and ((course.push.force > 0.0) != (pressing > 0.0)).any():
                # the rates have a kink, of which the estimate knows little
                error = max(error, course.halved(end, new, first, scale))
            if error <= 1.0:
                course.lay(end, new, stages)
                stop = _own_end(world, course)
        except NoSolution:  # also on the way to where a contact ceases to slide
            world.audit.rejected += 1
            h = 0.25 * (end - start)
            if h < BRINK * world.scales.time:
                if course.grip is None:
                    raise
                # no contact forces exist a moment from now: impulses take their place
                jam(world, course.island)
                world.dirty[course.members] = True
                return
            continue
        if error > 1.0:
            world.audit.rejected += 1
            h = (end - start) * max(0.2, 0.9 * error**-course.method.exponent)
            continue
        # what is there from the start is not the step's, and contacts are found as late as the search may be
        within = DEEP * max(world.search.tolerance, FINEST * world.scales.length)
        deepest = min(-within, 1.1 * course.gap.min(initial=0.0))
        if _overlap(world, course, stop, course.new) < deepest:
            world.audit.rejected += 1
            h = 0.5 * (stop - start)
            continue
        break
    world.audit.steps += 1
    proposed = _proposed(world, course, end - start, error)
    # a step that the limit cut short says nothing against the longer one
    world.pace[course.members] = max(h, proposed) if end == limit else proposed


def _proposed(world: World, course: Course, h: float, error: float) -> float:
    """Next step after one of h [s] with this error, relative to what is allowed.

    Where steps shrink, as they do towards the end of a slip that turns, the next one will have to as much again:
    Gustafsson, Control-theoretic techniques for stepsize selection in implicit Runge-Kutta methods, 1994.
    """
    fair = math.inf if error == 0.0 else h * error**-course.method.exponent
    before = float(world.fair[course.members].max())
    world.fair[course.members] = fair
    trend = min(1.0, max(0.2, fair / before)) if before < math.inf and fair < math.inf else 1.0
    return min(5.0 * h, 0.9 * fair * trend)


def _own_end(world: World, course: Course) -> float:
    """Shorten a step to where its bodies meet each other or what is fixed, leave a feature, or cease to slide."""
    while True:
        t = _meets(world, course)
        if _cut(world, [course], t):
            break
    stop = _slides_off(world, course)
    if stop < course.end:
        course.lay(stop, *course.carried(stop))
    if course.slip(course.end, course.new) < 0.0:
        course.lay(*_reversal(world, course))
    return course.end


def _meets(world: World, course: Course) -> float:
    """When bodies of an island first meet each other or what is fixed, or the end of the step [s]."""
    pairs = _near(world, course)
    for _ in range(1000 + 50 * len(pairs)):
        if len(pairs) == 0:
            return course.end
        p = int(pairs[np.argmin(world.clear[pairs])])
        if world.clear[p] >= course.end:
            return course.end
        if world.hits[p]:
            return float(world.clear[p])
        world.look(p)
    raise Stalled(f"search for the next contact of {', '.join(world.names(*course.members))}", world.t)


def _near(world: World, course: Course) -> np.ndarray:
    """Pairs of an island that are not too far apart to meet within its step; the others are clear until its end."""
    m, b, h = world.motion, world.bodies, course.end - course.begin
    pull = np.sqrt((m.bounds[:, :3] ** 2).sum(axis=1)) + m.bounds[:, 3]
    travel = b.reach + h * np.sqrt((m.x_series[:, 1] ** 2).sum(axis=1)) + 0.5 * h * h * pull
    if world.moving:
        travel[b.inverse_mass == 0.0] = math.inf  # their motion has not begun with the step
    one, other = world.detector.pairs[course.pairs].T
    away = m.x_series[one, 0] - m.x_series[other, 0]
    far = np.sqrt((away * away).sum(axis=1)) > travel[one] + travel[other]
    world.clear[course.pairs[far]] = np.maximum(world.clear[course.pairs[far]], course.end)
    return course.pairs[~far]


def _reversal(world: World, course: Course) -> tuple[float, np.ndarray, np.ndarray]:
    """When the first contact ceases to slide, the state then, and the rates on the way.

    The Illinois method on the slip of the motion itself, which is a straight line in time where friction is constant.
    At the stop a slip has no direction of its own, and takes that of the begin of the step.  Where it turns on its way
    the time is therefore one a little before, from where the next step goes to the stop almost straight.
    """
    low, high = course.begin, course.end
    stop, new, stages = course.end, course.new, course.stages
    above, below = course.slip(low, course.y), course.slip(high, new)
    side, lost = 0, 0
    before: tuple[float, np.ndarray, np.ndarray, Push] | None = None
    for _ in range(80):
        t = (low * below - high * above) / (below - above)
        if not low < t < high:
            t = 0.5 * (low + high)
        if t in (low, high):
            break
        way = course.tried(t) if lost < LOST else course.carried(t)
        if way is None:  # too close to the stop, or past it, where friction has no direction that it could keep
            lost += 1
            if lost == LOST and before is not None:
                stop, new, stages, course.push = before
                return stop, new, stages
            high, below, side = t, -above, 0
            continue
        new, stages = way
        stop, value = t, course.slip(t, new)
        if abs(value) <= STANDING * world.scales.speed:
            break
        if value > 0.0:
            low, above, before = t, value, (t, new, stages, course.push)
            below = 0.5 * below if side == 1 else below
            side = 1
        else:
            high, below = t, value
            above = 0.5 * above if side == -1 else above
            side = -1
    push, early = course.push, stop - SHORT * (stop - course.begin)
    earlier, rates = course.carried(early)
    if course.turns(early, earlier):
        return early, earlier, rates
    course.push = push
    return stop, new, stages


def cut(world: World, pair: int, t: float) -> bool:
    """End the steps of both bodies of a pair at time t, at which they meet; False if they do not quite.

    The polynomials of their steps are then better ones, and the meeting must be looked for again.
    """
    ends = world.detector.pairs[pair]
    return _cut(world, [c for c in world.courses if np.isin(ends, c.members).any()], t)


def _cut(world: World, courses: list[Course], t: float) -> bool:
    """End steps at time t if the motions are there where their polynomials had them; else lay these anew.

    Not up to t: if the bodies meet a little later than their polynomials said, a step that ends at t would end
    before they meet, and closer than what counts as touching.
    """
    ways = []
    for course in courses:
        if t < course.end:
            new, stages = (course.y, course.stages) if t <= course.begin else course.carried(t)
            course.cuts += 1
            agrees = course.deviation(t, new) <= world.search.tolerance or course.cuts > CUTS
            ways.append((course, new, stages, course.push, agrees))
    if all(agrees for *_, agrees in ways):
        for course, new, stages, push, _ in ways:
            course.push = push
            course.lay(t, new, stages)
        return True
    for course, *_, agrees in ways:
        if not agrees:
            end = min(t + BEYOND * (t - course.begin), 0.5 * (t + course.end))
            course.lay(end, *course.carried(end))
    return False


def interrupt(world: World, cluster: np.ndarray) -> bool:
    """Bring the islands of these bodies (boolean) that are on their way to the present; whether there were any."""
    late = [c for c in world.courses if cluster[c.members].any() and not c.arrived]
    for course in late:
        if course.end > -math.inf:
            if world.t < course.end:
                new, stages = course.carried(world.t) if world.t > course.begin else (course.y, course.stages)
                course.lay(world.t, new, stages)
            _arrive(world, course)
        course.arrived = True
        cluster[course.members] = True
    return bool(late)


def arrive(world: World) -> None:
    """Set the state of the islands whose step ends now; their contacts are then looked at again."""
    for course in world.courses:
        if course.end <= world.t and not course.arrived:
            _arrive(world, course)


def _arrive(world: World, course: Course) -> None:
    course.show(course.new)
    _restore(world, course)
    world.dirty[course.members] = True
    course.arrived = True


def show(world: World) -> None:
    """Set the state of the islands on their way to what it is now, by the motion itself; they go on undisturbed."""
    for course in world.courses:
        if course.begin < world.t < course.end:
            course.look(world.t)


def _slides_off(world: World, course: Course) -> float:
    """First time at which a contact has left its feature by a little more than the lateral tolerance, or the end."""
    contacts, end = course.island.contacts, course.end
    bounded = world.detector.bounded(contacts)
    if not bounded.any():
        return end
    contacts = contacts.chosen(bounded)
    out = world.detector.lateral
    low, high = _leaves(world, course, contacts)
    for _ in range(100):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        least = _margins(world, contacts, middle)
        if -3.0 * out <= least < -out:
            return middle
        if least < -out:
            high = middle
        else:
            low = middle
    return high


def _leaves(world: World, course: Course, contacts: Contacts) -> tuple[float, float]:
    """Times within the step between which a contact leaves its feature; its end twice if none does.

    No contact moves faster along its feature than bodies move there, so that margins at two times bound what is
    between them.  A contact that runs along an edge is looked at `LOOKS` times.
    """
    fastest, out = _fastest(world, course), world.detector.lateral
    end = (course.end, _margins(world, contacts, course.end))
    spans = [((course.begin, _margins(world, contacts, course.begin)), end)]
    looks = 0
    while spans:
        low, high = spans.pop()
        if high[1] < -out and (looks >= LOOKS or low[1] >= -out):
            return low[0], high[0]
        width = high[0] - low[0]
        if looks >= LOOKS or 0.5 * (low[1] + high[1] - fastest * width) >= -out:
            continue
        looks += 1
        middle = 0.5 * (low[0] + high[0])
        one = (middle, _margins(world, contacts, middle))
        spans += [(one, high), (low, one)]
    return end[0], end[0]


def _fastest(world: World, course: Course) -> float:
    """Bound of the velocity of material points relative to the other body of a contact within the step [m/s]."""
    m, b, h = world.motion, world.bodies, course.end - course.begin
    one, other = course.island.contacts.kinds[:, :2].T
    reach = np.where(b.inverse_mass > 0.0, b.reach, 0.0)  # those that are fixed do not turn
    turn, gain = m.bounds[:, 4] * reach, m.bounds[one, :3] - m.bounds[other, :3]
    away = m.v[one] - m.v[other]
    speed = np.sqrt((away * away).sum(axis=1)) + h * np.sqrt((gain * gain).sum(axis=1))
    return float((speed + h * (m.bounds[one, 3] + m.bounds[other, 3]) + turn[one] + turn[other]).max())


def _margins(world: World, contacts: Contacts, t: float) -> float:
    """Least margin of the contacts at time t of the segments [m]."""
    m = world.motion
    x, rotation, v, q, rate = m.x.copy(), np.empty((len(m.x), 3, 3)), np.empty(3), np.empty(4), np.empty(4)
    for i in set(contacts.kinds[:, :2].ravel().tolist()):
        where(t - m.begin[i], m.x_series[i], m.q_series[i], x[i], v, q, rate)
        rotation[i] = rotations(q[None])[0]
    return min(world.detector.margin(contacts, k, x, rotation) for k in range(len(contacts.kinds)))


def _overlap(world: World, course: Course, t: float, y: np.ndarray) -> float:
    """Deepest overlap within an island, or with what is fixed, at time t [m], negative or zero."""
    pose = course.place(t, y)
    dirty = np.zeros(len(world.mode), dtype=bool)
    dirty[course.members] = True
    own = dirty | (world.bodies.inverse_mass == 0.0)
    found = world.detector.contacts(pose.x, pose.rotation, dirty)
    found = found.chosen(own[found.kinds[:, 0]] & own[found.kinds[:, 1]])
    if len(found.kinds) == 0:
        return 0.0
    return min(0.0, float(kinematics(found, pose.x, pose.rotation, pose.v, pose.w).gap.min()))


def _restore(world: World, course: Course) -> None:
    """Take out what the integration changed of the gaps at the contacts that push.

    They keep the gap they had: to close it would push a neighbour that has just arrived into overlap.  Joints are
    closed: they have no gap.
    """
    loaded, island = course.loaded, course.island
    if loaded.any():
        x, pose = world.motion.x[course.members], Pose.now(world.motion, world.bodies)
        excess = island.problem(pose, world.bodies).k.gap - course.gap
        if np.abs(excess[loaded]).max() > ULPS * max(float(np.abs(x).max()), world.scales.length):
            island.part(loaded).shift(world.motion, world.bodies, course.gap[loaded])
    world.audit.drift = max(world.audit.drift, island.hold(world.motion, world.bodies))
