"""The plant every peer simulates: the paper's drillstring with its bit inertia, driven at 10 rad/s and 97 347 N.

Each peer starts from rest (no speed, no torque anywhere) and must find the stick-slip cycle of the paper's Fig. 2.
Nothing here is shared with the kit: a peer is what a user would write from the paper alone.
"""

from math import sqrt

SHEAR_MODULUS = 79.3e9  # N/m^2, G
POLAR_MOMENT = 1.19e-5  # m^4, J
LINE_INERTIA = 0.095  # kg m, I
LENGTH = 1172.0  # m, L
BIT_INERTIA = 89.0  # kg m^2, I_B (not in the paper)
TOP_DAMPING = 2000.0  # N m s, c_a
BIT_DAMPING = 0.03  # N m s/rad, c_b
BIT_RADIUS = 0.155575  # m, R_b
COULOMB = 0.5  # mu_cb
STATIC = 0.8  # mu_sb
DECAY = 0.9  # s/rad, gamma_b / v_f
OMEGA = 10.0  # rad/s, speed asked of the rotary table
WEIGHT_ON_BIT = 97347.0  # N

STIFFNESS = SHEAR_MODULUS * POLAR_MOMENT  # N m^2, G J
IMPEDANCE = sqrt(LINE_INERTIA * STIFFNESS)  # N m s, Z
TRAVEL_TIME = LENGTH * sqrt(LINE_INERTIA / STIFFNESS)  # s, Gamma
REFLECTION = (TOP_DAMPING - IMPEDANCE) / (TOP_DAMPING + IMPEDANCE)  # Upsilon
DRIVEN_WAVE = TOP_DAMPING / (TOP_DAMPING + IMPEDANCE) * OMEGA  # rad/s, the part of D that Omega sends down
STATIC_TORQUE = WEIGHT_ON_BIT * BIT_RADIUS * STATIC  # N m, dry torque at the edge of sticking
COULOMB_TORQUE = WEIGHT_ON_BIT * BIT_RADIUS * COULOMB  # N m, dry torque at high speed
