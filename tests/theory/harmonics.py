"""Cycles of a bit that never rests, by harmonic balance: Fourier series and the string's impedance at each harmonic."""

from __future__ import annotations

import numpy as np

from tests.oracle import OracleParameters


def balanced(
    p: OracleParameters, wob: float, slowest: float, guess: tuple[float, float, float, float], points: int = 151
) -> tuple[float, float, np.ndarray]:
    """Return Omega, the frequency [rad/s] and the bit speed at even points of the cycle with a least speed.

    `guess` is the mean and the amplitude of the bit speed, the frequency and Omega. The amplitude is brought up in
    small steps to where the least speed is as wanted.
    """
    mean, amplitude, frequency, omega = guess
    angles = 2 * np.pi * np.arange(points) / points
    speed = mean - amplitude * np.cos(angles)
    for least in np.linspace(mean - amplitude, slowest, 12):
        speed, frequency, omega = _newton(p, wob, least, speed, frequency, omega)
    return omega, frequency, speed


def _newton(
    p: OracleParameters, wob: float, least: float, speed: np.ndarray, frequency: float, omega: float
) -> tuple[np.ndarray, float, float]:
    size = speed.size
    order = np.fft.fftfreq(size, 1 / size)
    transform = np.fft.fft(np.eye(size), axis=0)

    def operator(gains: np.ndarray) -> np.ndarray:
        return np.fft.ifft(gains[:, None] * transform, axis=0).real

    slope = operator(1j * order)
    excess, rate = wob * p.R_b * (p.mu_sb - p.mu_cb), p.gamma_b / p.v_f
    for _ in range(30):
        s = 1j * order * frequency
        t = np.tanh(p.travel_time * s)
        z, c = p.impedance, p.c_a
        line = z * (c + z * t) / (z + c * t)
        line_by_s = z * p.travel_time * (1 - t**2) * (z**2 - c**2) / (z + c * t) ** 2
        gain = operator(p.I_B * s + line)
        by_frequency = operator((p.I_B + line_by_s) * 1j * order) @ speed
        falling = excess * np.exp(-rate * speed)
        torque = p.c_b * speed + wob * p.R_b * p.mu_cb + falling
        missed = np.concatenate([gain @ speed + torque - c * omega, [speed[0] - least, slope[0] @ speed]])
        matrix = np.zeros((size + 2, size + 2))
        matrix[:size, :size] = gain + np.diag(p.c_b - rate * falling)
        matrix[:size, size], matrix[:size, size + 1] = by_frequency, -c
        matrix[size, 0], matrix[size + 1, :size] = 1, slope[0]
        step = np.linalg.solve(matrix, -missed)
        speed, frequency, omega = speed + step[:size], frequency + step[size], omega + step[size + 1]
        if np.abs(step).max() < 1e-11:
            return speed, frequency, omega
    raise ArithmeticError("harmonic balance does not converge")
