"""Equations (1)-(41) as printed, misprints and all, in the glossary's letters."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from derivations.glossary import symbols
from derivations.paper.printed import Printed


def equations() -> dict[str, Printed]:
    """Return every printed equation by its number."""
    parts = (_stem(), _nozzle(), _circuit(), _flux(), _ansatz(), _integration(), _control(), _calibration())
    return {one.equation: one for part in parts for one in part}


def _stem() -> Iterator[Printed]:
    m, a_y, F_p, F_k, F_f, F_g, F_i = symbols("m a_y F_p F_k F_f F_g F_i")
    S_1, P_b, k, y, v, F_c, F_s, f_v, band, t = symbols("S_1 P_b k y v F_c F_s f_v epsilon t")
    yield Printed("1", m * a_y, F_p + F_k + F_f + F_g + F_i)
    yield Printed("2", F_p, S_1 * P_b)
    yield Printed("3", F_k, -k * y)
    yield Printed("4", v, sp.Derivative(sp.Function("y")(t), t))
    force = F_p + F_k
    friction = (
        (-F_c * sp.sign(v) - v * f_v, sp.Ne(v, 0)),
        (-force, sp.Abs(force) <= F_s),
        (-F_s * sp.sign(force), True),
    )
    yield Printed("5", F_f, sp.Piecewise(*friction))
    net = S_1 * P_b - k * y
    motion = (
        (net - F_c - v * f_v, v >= band),
        (sp.Integer(0), sp.And(sp.Abs(v) < band, sp.Abs(force) <= F_s)),
        (net - F_s, sp.And(sp.Abs(v) < band, force > F_s)),
        (net + F_s, sp.And(sp.Abs(v) < band, force < -F_s)),
        (net + F_c - v * f_v, v <= -band),
    )
    yield Printed("6", m * a_y, sp.Piecewise(*motion))


def _nozzle() -> Iterator[Printed]:
    Q_1, Q_2, Q_b, C_1, C_2, A_1, A_2, rho = symbols("Q_1 Q_2 Q_b C_q1 C_q2 A_1 A_2 rho")
    dP_1, dP_2, P_1, P_b, D_1, D_2, delta, delta_max, x = symbols("dP_1 dP_2 P_1 P_b D_1 D_2 delta delta_max x")
    yield Printed("7", Q_1, Q_2 + Q_b)
    yield Printed("8", Q_1, C_1 * A_1 * sp.sqrt(2 / rho) * dP_1)
    yield Printed("9", Q_2, C_2 * A_2 * sp.sqrt(2 / rho * dP_2))
    yield Printed("10", A_1, sp.pi / 4 * D_1**2)
    yield Printed("11", A_2, sp.pi * D_2 * delta)
    yield Printed("12", delta, delta_max - x)
    yield Printed("13", dP_1, P_1 - P_b)
    yield Printed("14", dP_2, P_b)
    inflow = sp.pi * C_1 * D_1**2 / 4 * sp.sqrt(2 / rho * (P_1 - P_b))
    yield Printed("15", Q_b, inflow - sp.pi * C_2 * D_2 * delta * sp.sqrt(2 / rho * P_b))
    yield Printed("16", P_b, C_1**2 * D_1**4 * P_1 / (16 * C_2**2 * D_2**2 * delta**2 + C_1**2 * D_1**4))


def _circuit() -> Iterator[Printed]:
    U, i, R_s, N, phi, psi, t = symbols("U i R_s N phi psi t")
    phi_i, phi_x, i_t, w = symbols("phi_i phi_x i_t w")
    yield Printed("17", U, i * R_s + sp.Derivative(sp.Function("psi")(t), t))
    yield Printed("18", psi, N * phi)
    yield Printed("19", U, i * R_s + N * (phi_i * i_t + phi_x * w))
    yield Printed("20", i_t, -i * R_s / (phi_i * N) + U / (phi_i * N) - phi_x / phi_i * w)


def _flux() -> Iterator[Printed]:
    i, N, phi, phi_delta, R, H_m, L_m, x, S, sigma, mu_0 = symbols("i N phi phi_delta R H_m L_m x S sigma mu_0")
    B, phi_i, phi_x, i_t, w, U, R_s = symbols("B phi_i phi_x i_t w U R_s")
    u_0 = sp.Symbol("u_0", positive=True)  # printed so; not in the glossary
    yield Printed("21", i * N, phi_delta * R + H_m * L_m)
    yield Printed("22", R, 2 * x / (u_0 * S))
    yield Printed("23", phi_delta, sigma * phi)
    yield Printed("24", B, mu_0 * H_m)
    path = L_m + 2 * sigma * x
    yield Printed("25", phi, i * N * mu_0 * S / path)
    yield Printed("26", phi_i, N * mu_0 * S / path)
    yield Printed("27", phi_x, 2 * sigma * N * mu_0 * S * i / path**2)
    core = N**2 * mu_0 * S
    supply = L_m * U / core + 2 * sigma * U / core * x
    loss = L_m * R_s / core * i + 2 * sigma * R_s / core * x * i
    yield Printed("28", i_t, supply - loss - 2 * sigma * i / path * w)


def _ansatz() -> Iterator[Printed]:
    a, b, j, s, x, i, w, i_t, X, X_t = symbols("a b j s x i w i_t X X_t")
    L_m, sigma, delta, delta_max, n, v = symbols("L_m sigma delta delta_max n nu")
    yield Printed("29", i_t, a + b * x - s * i / (j + s * x) * w)
    yield Printed("30", i_t / b, a / b + x - i / (j / b + x) * w / b)
    yield Printed("30-right", i_t / b, X - i / X * X_t / b)
    yield Printed("30-text", a / b, i / s)
    inner = (2 * v - 1) * n ** (1 / (v - 1)) / b * i
    yield Printed("31", delta, delta_max + L_m / (2 * sigma) - inner ** ((v - 1) / v))


def _integration() -> Iterator[Printed]:
    C_1, C_2, D_1, D_2, P_1, P_b, i, b, n, v = symbols("C_q1 C_q2 D_1 D_2 P_1 P_b i b n nu")
    L_m, sigma, delta_max, S_1, F_c, k, y, f_v, m, a_y = symbols("L_m sigma delta_max S_1 F_c k y f_v m a_y")
    C, D, E, F, velocity, band = symbols("C_33 D_33 E_33 F_33 v epsilon")
    inner = (2 * v - 1) * n ** (1 / (v - 1)) / b
    power = (v - 1) / v
    gap = delta_max + L_m / (2 * sigma) - (inner * i) ** power
    yield Printed("32", P_b, C_1**2 * D_1**4 * P_1 / (16 * C_2**2 * D_2**2 * gap**2 + C_1**2 * D_1**4))
    net = S_1 * C / ((D - E * i**power) ** 2 + F) - k * y - velocity * f_v
    motion = (
        (net - F_c, velocity >= band),
        (sp.Integer(0), sp.Abs(velocity) < band),
        (net + F_c, velocity <= -band),
    )
    yield Printed("33", m * a_y, sp.Piecewise(*motion))
    yield Printed("33-C", C, C_1**2 * D_1**4 * P_1)
    yield Printed("33-D", D, 4 * C_2 * D_2 * (delta_max + L_m / (2 * sigma)))
    yield Printed("33-E", E, 4 * C_2 * D_2 * inner**power)
    yield Printed("33-F", F, C_1**2 * D_1**4)


def _control() -> Iterator[Printed]:
    u, K_P, K_I, K_D, now, before, total, i_SC = symbols("u K_P K_I K_D e_0 e_1 e_sum i_SC")
    controller = K_P * now + K_I * total + K_D * (now - before)
    yield Printed("34", u, controller)
    yield Printed("41", u, controller + i_SC)


def _calibration() -> Iterator[Printed]:
    I_1, I_2, I_3, I_4, I_5, I_6 = symbols("I_1 I_2 I_3 I_4 I_5 I_6")
    A_1, A_2, A_3, B_1, B_2, B_3 = symbols("Y_1 Y_2 Y_3 B_1 B_2 B_3")
    k_1, k_2, k, b_1, b_2, W = symbols("k_1 k_2 k_m b_1 b_2 W")
    yield Printed("35", k_1, ((A_2 - A_1) / (I_2 - I_1) + (A_3 - A_2) / (I_3 - I_2)) / 2)
    yield Printed("36", k_2, ((B_2 - B_1) / (I_5 - I_4) + (B_3 - B_2) / (I_6 - I_5)) / 2)
    yield Printed("37", k, (k_1 + k_2) / 2)
    yield Printed("38", b_1, ((A_1 - k * I_1) + (A_2 - k * I_2) + (A_3 - k * I_3)) / 3)
    yield Printed("39", b_2, ((B_1 - k * I_4) + (B_2 - k * I_5) + (B_3 - k * I_6)) / 3)
    yield Printed("40", W, (b_2 - b_1) / k)
