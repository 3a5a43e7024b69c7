"""Speed of a textbook EKF over many flights at once, in numpy and in numba: for comparison with `mc`.

Nine states, rate and inertia, dense covariance, as printed in textbooks: Euler's equation by Runge-Kutta of fourth
order, transition I + A dt, K = P H' S^-1. The flight is that of `mc stsat3-spin-up`: at rest at first, a constant
torque, 6,001 samples at 10 Hz. Each lane has its own noise. One core, single precision.

    python filters.py [LANES]
"""

import sys
import time

import numba
import numpy as np

TRUE = np.array([14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016])
TORQUE = np.array([1e-3, 1e-3, -2e-3])
PRIOR = np.array([25, 25, 25, 2, 2, 2.0])
SIGMA = np.array([1e-3, 1e-3, 1e-3, 10, 10, 10, 2, 2, 2.0])
NOISE, PERIOD, SAMPLES = 1.8151e-4, 0.1, 6001
REAL = np.float32


def tensor(j):
    """Matrices of elements jxx jyy jzz jxy jxz jyz, in the last axis."""
    rows = [[j[..., 0], j[..., 3], j[..., 4]], [j[..., 3], j[..., 1], j[..., 5]], [j[..., 4], j[..., 5], j[..., 2]]]
    return np.stack([np.stack(row, -1) for row in rows], -2)


def cross_matrix(v):
    zero = np.zeros_like(v[..., 0])
    rows = [[zero, -v[..., 2], v[..., 1]], [v[..., 2], zero, -v[..., 0]], [-v[..., 1], v[..., 0], zero]]
    return np.stack([np.stack(row, -1) for row in rows], -2)


def regressor(w):
    """L with J w = L j."""
    x, y, z, zero = w[..., 0], w[..., 1], w[..., 2], np.zeros_like(w[..., 0])
    rows = [[x, zero, zero, y, z, zero], [zero, y, zero, x, zero, z], [zero, zero, z, zero, x, y]]
    return np.stack([np.stack(row, -1) for row in rows], -2)


def acceleration(inverse, inertia, w):
    momentum = np.einsum("...ik,...k", inertia, w)
    return np.einsum("...ik,...k", inverse, TORQUE.astype(w.dtype) - np.cross(w, momentum))


def predicted(inverse, inertia, w):
    h = w.dtype.type(PERIOD)
    a = acceleration(inverse, inertia, w)
    b = acceleration(inverse, inertia, w + h / 2 * a)
    c = acceleration(inverse, inertia, w + h / 2 * b)
    d = acceleration(inverse, inertia, w + h * c)
    return w + h / 6 * (a + 2 * b + 2 * c + d)


def flight():
    """True rates, rad/s."""
    inertia = tensor(TRUE)
    inverse, w = np.linalg.inv(inertia), np.zeros(3)
    rates = [w]
    for _ in range(SAMPLES - 1):
        w = predicted(inverse, inertia, w)
        rates.append(w)
    return np.array(rates)


def by_numpy(rates, lanes, rng):
    """All lanes at each sample, by numpy's operations on stacks of matrices."""
    x = np.tile(np.concatenate([np.zeros(3), PRIOR]).astype(REAL), (lanes, 1))
    p = np.tile(np.diag(SIGMA**2).astype(REAL), (lanes, 1, 1))
    noise, r = REAL(NOISE), np.eye(3, dtype=REAL) * REAL(NOISE**2)
    begun = time.perf_counter()
    for rate in rates.astype(REAL):
        measured = rate + noise * rng.standard_normal((lanes, 3), dtype=REAL)
        w, inertia = x[:, :3], tensor(x[:, 3:])
        inverse = np.linalg.inv(inertia)
        a = acceleration(inverse, inertia, w)
        by_rate = cross_matrix(np.einsum("nik,nk->ni", inertia, w)) - cross_matrix(w) @ inertia
        f = np.tile(np.eye(9, dtype=REAL), (lanes, 1, 1))
        f[:, :3, :3] += inverse @ by_rate * REAL(PERIOD)
        f[:, :3, 3:] = -inverse @ (regressor(a) + cross_matrix(w) @ regressor(w)) * REAL(PERIOD)
        x[:, :3] = predicted(inverse, inertia, w)
        p = f @ p @ f.transpose(0, 2, 1)
        gain = p[:, :, :3] @ np.linalg.inv(p[:, :3, :3] + r)
        x += np.einsum("nik,nk->ni", gain, measured - x[:, :3])
        p = p - gain @ p[:, :3, :]
        p = (p + p.transpose(0, 2, 1)) / 2
    return x[:, 3:], time.perf_counter() - begun


@numba.njit(fastmath=True)
def filter_lanes(rates, noise, x, p):
    """A block of lanes over the flight: lanes are the last axis of each array, and the innermost loop.

    The lower six rows of the transition are those of the identity, and are left out of the products.
    """
    lanes, real = x.shape[1], x.dtype.type
    h, r = real(PERIOD), real(NOISE * NOISE)
    torque = TORQUE.astype(x.dtype)
    f, t, k = np.zeros((3, 9, lanes), x.dtype), np.zeros((9, 9, lanes), x.dtype), np.zeros((4, 3, lanes), x.dtype)
    j, inv, s = np.zeros((3, 3, lanes), x.dtype), np.zeros((3, 3, lanes), x.dtype), np.zeros((3, 3, lanes), x.dtype)
    s_inv, w, momentum = np.zeros_like(s), np.zeros((3, lanes), x.dtype), np.zeros((3, lanes), x.dtype)
    e, of_w, column = np.zeros_like(w), np.zeros_like(w), np.zeros_like(w)
    first, second = (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)
    for n in range(rates.shape[0]):
        for m in range(6):
            for lane in range(lanes):
                j[first[m], second[m], lane] = j[second[m], first[m], lane] = x[3 + m, lane]
        invert(j, inv)
        w[:] = x[:3]
        for stage, share in ((0, 0.0), (1, 0.5), (2, 0.5), (3, 1.0)):
            for i in range(3):
                for lane in range(lanes):
                    before = k[max(stage - 1, 0), i, lane]
                    w[i, lane] = x[i, lane] + h * real(share) * before if stage > 0 else x[i, lane]
            times(j, w, momentum)
            for i in range(3):
                a, b = (i + 1) % 3, (i + 2) % 3
                for lane in range(lanes):
                    e[i, lane] = torque[i] - (w[a, lane] * momentum[b, lane] - w[b, lane] * momentum[a, lane])
            times(inv, e, k[stage])
        w[:] = x[:3]
        times(j, w, momentum)
        f[:] = 0
        for c in range(3):
            # Derivative of (J w) x w by component c of w: (J w) x e - w x (J e).
            for i in range(3):
                of_w[i] = j[i, c]
                e[i] = 1 if i == c else 0
            for i in range(3):
                a, b = (i + 1) % 3, (i + 2) % 3
                for lane in range(lanes):
                    left = momentum[a, lane] * e[b, lane] - momentum[b, lane] * e[a, lane]
                    column[i, lane] = left - (w[a, lane] * of_w[b, lane] - w[b, lane] * of_w[a, lane])
            times(inv, column, e)
            for i in range(3):
                for lane in range(lanes):
                    f[i, c, lane] = h * e[i, lane] + (real(1) if i == c else real(0))
        for m in range(6):
            # Derivative by element m: - (M a + w x (M w)), M with ones at its two places.
            i, q = first[m], second[m]
            e[:] = 0
            of_w[:] = 0
            for lane in range(lanes):
                e[i, lane], of_w[i, lane] = k[0, q, lane], w[q, lane]
                e[q, lane], of_w[q, lane] = k[0, i, lane], w[i, lane]
            for i in range(3):
                a, b = (i + 1) % 3, (i + 2) % 3
                for lane in range(lanes):
                    column[i, lane] = e[i, lane] + w[a, lane] * of_w[b, lane] - w[b, lane] * of_w[a, lane]
            times(inv, column, e)
            for i in range(3):
                for lane in range(lanes):
                    f[i, 3 + m, lane] = -h * e[i, lane]
        for i in range(3):
            for c in range(9):
                t[i, c] = 0
                for m in range(9):
                    for lane in range(lanes):
                        t[i, c, lane] += f[i, m, lane] * p[m, c, lane]
        p[:3] = t[:3]
        for i in range(9):
            for c in range(3):
                t[i, c] = 0
                for m in range(9):
                    for lane in range(lanes):
                        t[i, c, lane] += p[i, m, lane] * f[c, m, lane]
        p[:, :3] = t[:, :3]
        for i in range(3):
            for lane in range(lanes):
                rate = x[i, lane] + h / 6 * (k[0, i, lane] + 2 * k[1, i, lane] + 2 * k[2, i, lane] + k[3, i, lane])
                x[i, lane] = rate
                column[i, lane] = rates[n, i] + noise[n, i, lane] - rate
        s[:] = p[:3, :3]
        for i in range(3):
            s[i, i] += r
        invert(s, s_inv)
        t[:3] = p[:3]
        for i in range(9):
            for c in range(3):
                for lane in range(lanes):
                    gain = real(0)
                    for m in range(3):
                        gain += t[m, i, lane] * s_inv[m, c, lane]
                    t[3 + c, i, lane] = gain
        for i in range(9):
            for lane in range(lanes):
                for c in range(3):
                    x[i, lane] += t[3 + c, i, lane] * column[c, lane]
            for q in range(i, 9):
                for lane in range(lanes):
                    left = p[i, q, lane]
                    for c in range(3):
                        left -= t[3 + c, i, lane] * t[c, q, lane]
                    p[i, q, lane] = p[q, i, lane] = left


@numba.njit(fastmath=True)
def times(m, v, out):
    for i in range(3):
        for lane in range(v.shape[1]):
            out[i, lane] = m[i, 0, lane] * v[0, lane] + m[i, 1, lane] * v[1, lane] + m[i, 2, lane] * v[2, lane]


@numba.njit(fastmath=True)
def invert(m, out):
    for i in range(3):
        for k in range(3):
            a, b, c, d = (k + 1) % 3, (k + 2) % 3, (i + 1) % 3, (i + 2) % 3
            for lane in range(m.shape[2]):
                out[i, k, lane] = m[a, c, lane] * m[b, d, lane] - m[a, d, lane] * m[b, c, lane]
    for lane in range(m.shape[2]):
        det = m[0, 0, lane] * out[0, 0, lane] + m[0, 1, lane] * out[1, 0, lane] + m[0, 2, lane] * out[2, 0, lane]
        for i in range(3):
            for k in range(3):
                out[i, k, lane] /= det


def by_numba(rates, lanes, rng):
    """Blocks of lanes, compiled."""
    rates, block, spent, found = rates.astype(REAL), 64, 0.0, []
    for number in range(-1, -(-lanes // block)):  # The first one compiles.
        x = np.tile(np.concatenate([np.zeros(3), PRIOR]).astype(REAL)[:, None], (1, block))
        p = np.tile(np.diag(SIGMA**2).astype(REAL)[:, :, None], (1, 1, block))
        noise = REAL(NOISE) * rng.standard_normal((SAMPLES, 3, block), dtype=REAL)
        begun = time.perf_counter()
        filter_lanes(rates, noise, x, p)
        if number >= 0:
            spent += time.perf_counter() - begun
            found.append(x[3:].T)
    return np.concatenate(found), spent


def main():
    lanes = int(sys.argv[1]) if len(sys.argv) > 1 else 256
    rates = flight()
    print("filter              lanes    steps/s per core    RMS error of jxx, kg m^2    not within 20 %")
    for name, run in [("numpy", by_numpy), ("numba", by_numba)]:
        found, spent = run(rates, lanes, np.random.default_rng(0))
        error = found[:, 0] - TRUE[0]
        lost = ~(np.abs(error) < 0.2 * TRUE[0])
        rms = np.sqrt(np.mean(error[~lost] ** 2))
        print(f"{name:<18} {len(found):>6} {len(found) * SAMPLES / spent:>19.3g} {rms:>27.3g} {lost.sum():>18}")


if __name__ == "__main__":
    main()
