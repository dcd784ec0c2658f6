"""Trajectories are read-only, cut where asked, and their digest sees the last bit."""

import numpy as np
import pytest

from mechanics.trajectory import State, Trajectory


def motion(shift=0.0):
    states = [
        State(k * 0.1, np.full((2, 3), k + shift), np.tile([1.0, 0, 0, 0], (2, 1)), np.zeros((2, 3)), np.zeros((2, 3)))
        for k in range(4)
    ]
    return Trajectory.of(states)


def test_states_come_back():
    assert motion().at(2).t == pytest.approx(0.2)
    assert motion().at(2).x.tolist() == [[2.0] * 3] * 2
    assert len(motion().until(2)) == 2


def test_arrays_cannot_be_written():
    with pytest.raises(ValueError, match="read-only"):
        motion().x[0, 0, 0] = 1.0


def test_the_digest_sees_the_last_bit():
    assert motion().digest() == motion().digest()
    assert motion().digest() != motion(np.finfo(float).eps * 8).digest()
