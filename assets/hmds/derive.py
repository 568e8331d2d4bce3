#!/usr/bin/env python3
"""Writes the headset descriptors beside it from published numbers; what is computed, and how, stands here.

    python3 assets/hmds/derive.py [folder of OSVR descriptors, default ../shared/data/hmd]

The OSVR HDK 2.0 is fitted to the distortion samples of OSVR's own descriptor and is left as it is when that folder is absent.
"""
import json
import math
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent


def digits(value):
    """Ten significant digits: more than anybody measured, and the same on every machine."""
    if isinstance(value, float):
        return float(f"{value:.10g}")
    if isinstance(value, dict):
        return {k: digits(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [digits(v) for v in value]
    return value


def write(file, name, source, ipd_m, timing, left, right="mirrored", follows=False):
    text = json.dumps(digits({
        "schema": "holdfast/hmd/1", "name": name, "source": source, "ipd_m": ipd_m, "optics_follow_ipd": follows,
        "timing": timing, "eyes": {"left": left, "right": right}}), indent=2)
    (HERE / file).write_text(text + "\n")


def solve(matrix, right):
    """Gaussian elimination with pivoting."""
    n = len(right)
    rows = [list(r) + [b] for r, b in zip(matrix, right)]
    for i in range(n):
        p = max(range(i, n), key=lambda r: abs(rows[r][i]))
        rows[i], rows[p] = rows[p], rows[i]
        for r in range(n):
            if r != i:
                f = rows[r][i] / rows[i][i]
                rows[r] = [x - f * y for x, y in zip(rows[r], rows[i])]
    return [rows[i][n] / rows[i][i] for i in range(n)]


def least_squares(rows, values):
    n = len(rows[0])
    normal = [[sum(r[i] * r[j] for r in rows) for j in range(n)] for i in range(n)]
    return solve(normal, [sum(r[i] * v for r, v in zip(rows, values)) for i in range(n)])


def times(polynomial, c0, c1):
    """(p0 + p1 x + ...) (c0 + c1 x)"""
    out = [0.0] * (len(polynomial) + 1)
    for i, p in enumerate(polynomial):
        out[i] += p * c0
        out[i + 1] += p * c1
    return out


def lens(polynomial, r_norm, centre=(0.0, 0.0)):
    return {"model": "polynomial", "k0": polynomial[0], "coefficients": polynomial[1:], "r_norm": r_norm,
            "centre": list(centre)}


def flight_helmet():
    write("flight_helmet.json", "Virtual Research Flight Helmet",
          "Robinett & Holloway 1994 (SIGGRAPH 2001 course 11), table 8.1, paraxial values; entries that lost their decimal point "
          "in print restored so that the optics agree with themselves (66.3 by 53.5 degrees). The paper counts the lens's radius in "
          "pixels (r_norm 256, the half height); here it is the tangent of that half height. Refresh: NTSC's, not in the table.",
          0.062, {"refresh_hz": 59.94},
          {"resolution_px": [640, 512],
           "virtual_image_m": {"w_x": 1.57, "w_y": 1.19, "z_p": -1.18, "x_cw": -0.187, "y_cw": 0.0}, "eye_relief_m": 0.025,
           "lens": {"model": "radial", "k": 0.1933, "k_pd": -0.1, "r_norm": 1.19 / 2 / 1.18, "centre": [0.0, 0.0]}})


def azuma_see_through():
    per_pixel = 2 * math.tan(math.radians(15)) / 640  # 30 degrees across, square pixels
    right = {"left": -330 * per_pixel, "right": 310 * per_pixel, "down": -255 * per_pixel, "up": 257 * per_pixel}
    write("azuma_see_through.json", "UNC optical see-through HMD",
          "Azuma & Bishop 1994: about 30 degrees per eye (section 3; Holmgren, UNC TR92-030), frame buffer 640 x 512 NTSC, measured "
          "centre (330, 255) of the right eye (4.3), horizontal field by the buffer's aspect. Derived: tangents with 30 degrees taken "
          "as the width of 640 square pixels. Assumed: IPD 62 mm, left eye mirrored (the paper uses the right eye only). Its small "
          "distortion was not measured. The LCDs themselves have 340 x 240 pixels.",
          0.062, {"refresh_hz": 60.0}, "mirrored", {"resolution_px": [640, 512], "tangents": right, "lens": {"model": "none"}})


def rift_dk1():
    width, height, to_screen, separation = 0.14976, 0.0936, 0.041, 0.0635
    quarter = width / 4
    t = {"left": -(width / 2 - separation / 2) / to_screen, "right": separation / 2 / to_screen,
         "down": -height / 2 / to_screen, "up": height / 2 / to_screen}
    green = [1.0, 0.22, 0.24]
    write("rift_dk1.json", "Oculus Rift DK1",
          "Oculus SDK 0.2 (HMDInfo): screen 149.76 x 93.6 mm, 1280 x 800, eye to screen 41 mm, lens separation 63.5 mm, IPD 64 mm, "
          "distortionK 1, 0.22, 0.24, 0 with the radius in quarters of the screen's width, chromaAb 0.996, -0.004, 1.014, 0. Derived: "
          "tangents = lengths on the screen / 41 mm.",
          0.064, {"refresh_hz": 60.0},
          {"resolution_px": [640, 800], "tangents": t, "lens": lens(green, quarter / to_screen),
           "lens_red": lens(times(green, 0.996, -0.004), quarter / to_screen),
           "lens_blue": lens(times(green, 1.014, 0.0)[:3], quarter / to_screen)})


DK2_KNOTS = [1.003, 1.02, 1.042, 1.066, 1.094, 1.126, 1.162, 1.203, 1.25, 1.31, 1.38]


def dk2_lens(chroma=None):
    """Oculus SDK 0.4's Catmull-Rom spline; red and blue are green times 1 + chroma[0] + chroma[1] r^2."""
    spline = {"model": "catmull_rom", "knots": DK2_KNOTS, "r_max": 1.0}
    if chroma:
        spline["chroma"] = chroma
    return {**spline, "r_norm": 1.0, "centre": [0.0, 0.0]}


def rift_dk2():
    width, height, per_tangent, separation, from_top = 0.12576, 0.07074, 0.036, 0.0635, 0.0353
    t = {"left": -(width / 2 - separation / 2) / per_tangent, "right": separation / 2 / per_tangent,
         "down": -(height - from_top) / per_tangent, "up": from_top / per_tangent}
    near = {"eye_relief_m": 0.008, "red": [-0.0112, -0.015], "blue": [0.0187, 0.015]}
    far = {"eye_relief_m": 0.018, "red": [-0.015, -0.02], "blue": [0.025, 0.02]}
    part = (0.011 - near["eye_relief_m"]) / (far["eye_relief_m"] - near["eye_relief_m"])
    red, blue = ([n + part * (f - n) for n, f in zip(near[c], far[c])] for c in ("red", "blue"))
    rows = [{"eye_relief_m": row["eye_relief_m"], "lens": dk2_lens(), "lens_red": dk2_lens(row["red"]),
             "lens_blue": dk2_lens(row["blue"])} for row in (near, far)]
    write("rift_dk2.json", "Oculus Rift DK2",
          "Oculus SDK 0.4 (HmdRenderInfo and LensConfig of eye cup A): screen 125.76 x 70.74 mm, 1920 x 1080, lens separation 63.5 mm, "
          "lens centre 35.3 mm from the top, 36 mm per unit of tangent, the SDK's own spline for reliefs of 8 and 18 mm (they differ in "
          "their chroma alone). Derived: tangents; chroma at a relief of 11 mm. Persistence 2.3 ms at 75 Hz. Its scan runs from right to "
          "left over both eyes' halves, 13.1 ms in all, so that each eye has times of its own; one timing for both cannot express that, "
          "and it is given as global. IPD 64 mm is the SDK's default.",
          0.064, {"refresh_hz": 75.0, "scan_out": "global", "persistence_ms": 2.3},
          {"resolution_px": [960, 1080], "tangents": t, "eye_relief_m": 0.011, "lens": dk2_lens(), "lens_red": dk2_lens(red),
           "lens_blue": dk2_lens(blue), "lenses_at_relief": rows})


def osvr_hdk_2_0(folder):
    file = folder / "builtin_osvr_hdk20_v1.json"
    if not file.exists():
        print(f"{file} is absent: osvr_hdk_2_0.json is left as it is")
        return
    samples = json.loads(file.read_text())["display"]["hmd"]["distortion"]["mono_point_samples"][0]
    half = math.tan(math.radians(92 / 2))
    middle = min(samples, key=lambda s: (s[1][0] - 0.5) ** 2 + (s[1][1] - 0.5) ** 2)[0]
    pairs = []
    for screen, canonical in samples:
        panel = math.hypot((screen[0] - middle[0]) * 1080, (screen[1] - middle[1]) * 1200)
        seen = math.hypot(2 * canonical[0] - 1, 2 * canonical[1] - 1) * half
        if panel > 0:
            pairs.append((panel, seen))
    unit = 600.0
    value = lambda fit, p: sum(c * (p / unit) ** (2 * i + 1) for i, c in enumerate(fit))
    kept, fit = pairs, []
    for _ in range(3):  # some samples lie degrees off their neighbours: leave out those more than a degree from the last fit
        fit = least_squares([[(p / unit) ** (2 * i + 1) for i in range(4)] for p, _ in kept], [s for _, s in kept])
        kept = [(p, s) for p, s in pairs if abs(value(fit, p) - s) < math.radians(1)]
    errors = [value(fit, p) - s for p, s in kept]
    rms = math.sqrt(sum(e * e for e in errors) / len(errors))
    print(f"HDK 2.0: fit {fit}, rms {math.degrees(rms) * 60:.1f} arcmin over {len(kept)} of {len(pairs)} samples, farthest "
          f"{max(p for p, _ in kept):.0f} px")
    per_px = fit[0] / unit
    t = {"left": -middle[0] * 1080 * per_px, "right": (1 - middle[0]) * 1080 * per_px, "down": -middle[1] * 1200 * per_px,
         "up": (1 - middle[1]) * 1200 * per_px}
    write("osvr_hdk_2_0.json", "OSVR HDK 2.0",
          "OSVR's descriptor OSVR_HDK_2_0.json: 2160 x 1200 for both eyes, 92 by 92 degrees, distortion samples OSVR_HDK_20_V1 (Apache-2.0). "
          f"Derived: radial polynomial fitted to the left eye's samples (RMS {math.degrees(rms) * 60:.1f} arcmin over {len(kept)} of {len(pairs)}; the rest lie more than a degree off), in paraxial tangents; "
          "beyond the last samples, in the panel's corners, it is extrapolated and folds over. Assumed: IPD 63 mm; 90 Hz is the panel's published rate.",
          0.063, {"refresh_hz": 90.0},
          {"resolution_px": [1080, 1200], "tangents": t, "lens": lens([1.0] + [c / fit[0] for c in fit[1:]], unit * per_px)})


def cardboard_v1():
    width, height, bevel = 0.110, 0.062, 0.004
    separation, baseline, to_screen = 0.060, 0.035, 0.042
    t = {"left": -(width / 2 - separation / 2) / to_screen, "right": separation / 2 / to_screen,
         "down": -(baseline - bevel) / to_screen, "up": (height - (baseline - bevel)) / to_screen}
    write("cardboard_v1.json", "Google Cardboard v1",
          "Google's viewer profile Cardboard I/O 2014: lens separation 60 mm, tray to lens 35 mm, screen to lens 42 mm, distortion 0.441, "
          "0.156 (radius in tangents), field limited to 40 degrees a side. Phone: the profile library's default Android, 110 x 62 mm "
          "with a bevel of 4 mm, here with 1920 x 1080 pixels at 60 Hz. Derived: tangents = lengths on the screen / 42 mm. IPD = lens "
          "separation.",
          separation, {"refresh_hz": 60.0},
          {"resolution_px": [960, 1080], "tangents": t, "lens": lens([1.0, 0.441, 0.156], 1.0)})


def wide_canted():
    write("wide_canted_90hz.json", "Wide canted (Pimax 5K Plus, small field)",
          "Tangents and render target as the Pimax 5K Plus reports them to OpenVR with parallel projection off, field 'small' (PiTool "
          "1.0.1.91; published by its owners with the tool hmdq): left eye -1.197888, 1.346154, 1.269841, 2638 x 2633; each eye turned "
          "outward by 10 degrees, 120.3 by 103.6 degrees for both together. 90 Hz is the panel's rate. The vendor's runtime corrects its "
          "lenses, whose distortion is not published: none here. IPD 60 mm: a setting of its mechanical adjustment.",
          0.060, {"refresh_hz": 90.0},
          {"resolution_px": [2638, 2633], "tangents": {"left": -1.197888, "right": 1.346154, "down": -1.269841, "up": 1.269841},
           "divergence_deg": 20.0, "lens": {"model": "none"}}, follows=True)


if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else HERE.parents[2] / "shared" / "data" / "hmd"
    flight_helmet()
    azuma_see_through()
    rift_dk1()
    rift_dk2()
    osvr_hdk_2_0(folder)
    cardboard_v1()
    wide_canted()
