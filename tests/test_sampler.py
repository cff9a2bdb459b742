# SPDX-License-Identifier: GPL-3.0-or-later
"""The sampler's points are what the papers say: nets in base 2, scrambled after Owen, shared by neighbouring pixels.

The properties are checked against definitions and against Sobol' points made here from their direction numbers, not
against the other device, which shares the code.
"""

from __future__ import annotations

import ctypes
import functools

import numpy as np
import pytest

from native_build import build

DIGITS = 24  # of a number in [0, 1)


@functools.cache
def library() -> ctypes.CDLL:
    return build('sampler_test', ['tests/native/sampler_test.cpp'])


def _pointer(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def points(count: int, pair: int = 0, pixel: tuple[int, int] = (3, 5), bits: int = 10, seed: int = 0, first: int = 0):
    """(N, 2) samples of one pixel, in double precision."""
    out = np.zeros((count, 2), np.float32)
    library().test_points(*pixel, first, bits, seed, pair, _pointer(out), ctypes.c_size_t(count))
    return out.astype(np.float64)


def owen_hash(x: np.ndarray, seed: int) -> np.ndarray:
    x = np.ascontiguousarray(x, np.uint32)
    out = np.zeros_like(x)
    library().test_owen_hash(_pointer(x), ctypes.c_uint32(seed), _pointer(out), ctypes.c_size_t(x.size))
    return out


def is_net(p: np.ndarray) -> bool:
    """Whether 2^m points are a (0, m, 2)-net in base 2: one in each of the 2^m boxes of every shape."""
    m = len(p).bit_length() - 1
    for k in range(m + 1):
        box = (p[:, 0] * 2**k).astype(int) * 2 ** (m - k) + (p[:, 1] * 2 ** (m - k)).astype(int)
        if len(np.unique(box)) != len(p):
            return False
    return True


def sobol(count: int) -> np.ndarray:
    """(N, 2) digits of the first two dimensions of Sobol's sequence: van der Corput's, and that of the polynomial
    x + 1, whose direction numbers are m_1 = 1, m_k = 2 m_(k-1) xor m_(k-1)."""
    m = [1]
    while len(m) < 32:
        m.append((2 * m[-1]) ^ m[-1])
    directions = [[1 << (31 - k) for k in range(32)], [(m[k] << (31 - k)) & 0xFFFFFFFF for k in range(32)]]
    out = np.zeros((count, 2), np.uint64)
    for i in range(count):
        for d in range(2):
            value = 0
            for k in range(32):
                value ^= directions[d][k] if i >> k & 1 else 0
            out[i, d] = value
    return out


def shared_digits(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """How many leading binary digits two numbers of 32 have in common, at most DIGITS."""
    apart = (a ^ b).astype(np.float64)
    return np.where(apart > 0.0, np.minimum(31 - np.floor(np.log2(np.maximum(apart, 1.0))), DIGITS), DIGITS).astype(int)


def test_the_reference_is_a_net() -> None:
    """Else the tests below would be worth nothing; random points are none."""
    reference = sobol(256) / 2.0**32
    assert is_net(reference) and is_net(reference[64:128])
    assert not is_net(np.random.default_rng(1).random((256, 2)))


@pytest.mark.parametrize('pair', [0, 1, 4, 259, 100_000])
def test_samples_of_a_pixel_are_nets(pair: int) -> None:
    """Every aligned run of 2^m samples, at any time of a render."""
    found = points(1024, pair)
    assert found.min() >= 0.0 and found.max() < 1.0
    for m in range(11):
        size = 2**m
        for first in {0, size * ((1024 // size) // 2), 1024 - size}:
            assert is_net(found[first : first + size]), f'{size} samples from {first} on'
    # Samples past the number that was asked for belong to the next run.
    assert is_net(points(256, pair, bits=8, first=256))


@pytest.mark.parametrize('pair', [0, 7])
def test_neighbouring_pixels_share_one_net(pair: int) -> None:
    """An aligned block of 2^k x 2^k pixels along the Morton curve: its error is spread among them."""
    for side in (2, 4, 8):
        block = [points(16, pair, (side * 3 + x, side * 2 + y), bits=4) for y in range(side) for x in range(side)]
        assert is_net(np.concatenate(block)), f'{side} x {side} pixels'


@pytest.mark.parametrize('pair', [0, 3, 500])
def test_points_are_sobols_scrambled_after_owen(pair: int) -> None:
    """Two points share exactly as many leading digits of both numbers as they did before scrambling. Samples come in
    another order than Sobol's, so all pairs of a run are compared at once."""
    reference = sobol(256)
    found = (points(256, pair, pixel=(0, 0), bits=8) * 2.0**32).astype(np.uint64)
    i, j = np.triu_indices(256, 1)

    def relations(p: np.ndarray) -> np.ndarray:
        shared = [shared_digits(p[i, axis], p[j, axis]) for axis in (0, 1)]
        return np.histogram2d(*shared, bins=DIGITS + 1, range=[[0, DIGITS + 1]] * 2)[0]

    assert (relations(found) == relations(reference)).all()


@pytest.mark.parametrize('seed', [0, 1, 0x9E3779B9, 0xFFFFFFFF])
def test_scrambling_is_nested_and_uniform(seed: int) -> None:
    """Bit i of the hash depends on bits 0 to i alone, and no two numbers meet: a permutation at every depth."""
    x = np.random.default_rng(2).integers(0, 2**32, 4096, dtype=np.uint32)
    for bit in range(32):
        low = np.uint32((1 << bit) - 1)
        changed = owen_hash(x ^ np.uint32(1 << bit), seed) ^ owen_hash(x, seed)
        assert not (changed & low).any(), f'bit {bit} changes those below it'
        assert (changed >> np.uint32(bit) & 1).all(), f'bit {bit} is lost'


def test_scrambling_differs_from_seed_to_seed() -> None:
    """Each digit of a point is turned over for half of the seeds, and those of two points that part at the first digit
    independently: otherwise pixels would see the same pattern."""
    drawn = np.array([(points(2, pair) * 2.0**DIGITS).astype(np.int64) for pair in range(2000)])
    digits = drawn[..., None] >> np.arange(DIGITS - 1, -1, -1) & 1  # (seed, point, axis, digit)
    standard_error = 0.5 / np.sqrt(len(drawn))
    assert np.abs(digits.mean(axis=0) - 0.5).max() < 5.0 * standard_error
    # Two samples part at the first digit; the digits after it, and those of both axes, are nobody's copies.
    turned = digits[:, 0, :, 1:9].reshape(len(drawn), -1) - 0.5
    other = digits[:, 1, :, 1:9].reshape(len(drawn), -1) - 0.5
    together = np.concatenate([turned, other], axis=1)
    correlation = np.corrcoef(together.T) - np.eye(together.shape[1])
    assert np.abs(correlation).max() < 5.0 / np.sqrt(len(drawn))


def test_the_axes_are_scrambled_independently() -> None:
    """Both numbers of a point share k digits as often as independent ones, for one point in 2^k. With one seed for both
    axes they would share those that Sobol's points share: in some nets often, in all others never."""
    nets, size = 64, 1 << 14
    drawn = [(points(size, pair, bits=14) * 2.0**32).astype(np.uint64) for pair in range(nets)]
    shared = shared_digits(*np.concatenate(drawn).T)
    for k in range(1, 14):
        expected = nets * size / 2**k
        assert abs((shared >= k).sum() - expected) < 5.0 * np.sqrt(expected), f'{k} digits'


def test_numbers_are_uniform_from_pixel_to_pixel() -> None:
    """With one sample a pixel, over pairs: no corner of the square is missed."""
    found = np.concatenate([points(1, pair, (x, x // 3)) for pair in range(60) for x in range(60)])
    counts = np.histogram2d(found[:, 0], found[:, 1], bins=8, range=[[0, 1], [0, 1]])[0]
    expected = len(found) / 64
    chi2 = ((counts - expected) ** 2 / expected).sum()
    assert chi2 < 63 + 5.0 * np.sqrt(2 * 63)


def test_it_integrates_as_scrambled_nets_do() -> None:
    """The variance of a smooth integrand falls with N^-3 (Owen 1997): at 1024 samples it is far below that of random
    points, which falls with N^-1, and below that of a grid of jittered ones, with N^-2."""

    def error(p: np.ndarray) -> float:
        return float(np.mean(np.exp(p[:, 0]) * np.cos(p[:, 1])) - (np.e - 1.0) * np.sin(1.0))

    few = np.mean([error(points(64, pair)) ** 2 for pair in range(100)])
    many = np.mean([error(points(1024, pair)) ** 2 for pair in range(100)])
    assert 16.0**2.5 < few / many < 16.0**3.5
    assert abs(np.mean([error(points(64, pair)) for pair in range(100)])) < 4.0 * np.sqrt(few / 100)
