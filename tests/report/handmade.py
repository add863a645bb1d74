# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Runs made by hand: the folders that `slim_init ab` would have written."""
import json
import math
import os

import pandas

COLUMNS = """dataset trial t_start_s t_start_ns duration_s keyframes excited
rig_td_ms rig_rotation_deg rig_readout_ms method status answer_keyframes answer_s attempted success scale
scale_error gravity_error_deg velocity_rmse velocity_vec_rmse pose_rmse gyro_bias_err_pct
gyro_bias_vec_err scale_sigma td_error_ms td_sigma_ms rotation_error_deg rotation_sigma_deg
rotation_over_sigma readout_error_ms readout_sigma_ms noise_px warnings point_tracks line_tracks gates message not_evaluated downstream
downstream_s downstream_diverged downstream_ate downstream_scale_error downstream_message solve_cpu_ms
solve_ms stages_ms""".split()

STEP_S, LENGTH_S = 0.5, 2.25


def row(trial, method, scale=1.0, status="success", excited=True, **more):
    """One row of windows.csv; scale None: no estimate. Errors are multiples of |scale - 1|."""
    error = math.nan if scale is None else abs(scale - 1.0)
    values = dict.fromkeys(COLUMNS, "")
    values.update(
        dataset="V9_99", trial=trial, t_start_s=STEP_S * trial, duration_s=LENGTH_S, keyframes=10,
        t_start_ns=1403715523912143104 + 500000000 * trial, excited=int(excited),
        method=method, status=status, answer_keyframes=10,
        answer_s=LENGTH_S, attempted=int(scale is not None),
        success=int(scale is not None and error < 0.5), message='said "so", twice', downstream=0,
        point_tracks=100, line_tracks=20, solve_cpu_ms=1.0, solve_ms=2.0,
        stages_ms="one=0.5;two=0.25")
    if scale is not None:
        values.update(scale=scale, scale_error=error, gravity_error_deg=10.0 * error,
                      velocity_rmse=2.0 * error, velocity_vec_rmse=3.0 * error,
                      pose_rmse=4.0 * error, gyro_bias_err_pct=50.0 * error,
                      gyro_bias_vec_err=0.1 * error)
    values.update(more)
    return values


def by_hand():
    """Five windows of one method; the last two are not excited."""
    return [row(0, "hand", 1.03, solve_cpu_ms=0.5, solve_ms=1.0),
            row(1, "hand", 0.6, solve_cpu_ms=1.0, solve_ms=2.0),
            row(2, "hand", 0.96, "scale_too_uncertain", solve_cpu_ms=1.5, solve_ms=3.0),
            row(3, "hand", 1.7, excited=False, solve_cpu_ms=5.0, solve_ms=10.0),
            row(4, "hand", None, "too_few_tracks", excited=False, not_evaluated="no estimate",
                solve_cpu_ms=49.5, solve_ms=99.0)]


def write_run(folder, rows, **info):
    """Writes windows.csv and summary.json of a run into `folder` and returns it."""
    os.makedirs(folder, exist_ok=True)
    pandas.DataFrame(rows, columns=COLUMNS).to_csv(os.path.join(folder, "windows.csv"), index=False)
    windows = len({r["trial"] for r in rows})
    summary = {
        "dataset": "V9_99", "command": "slim_init ab --something '<x>'", "version": "1.2.3",
        "commit": "0123abcd", "gyro_bias_truth": "recorded", "has_truth": True,
        "notes": ["rows & <columns> | bars"],
        "options": {"recorded": "DIR", "world": "room", "points": 100, "lines": 25, "seed": 7,
                    "pixel_noise": 0.6, "odd": "a|b"},
        "trials": {"frames": 100, "trials": windows + 5, "windows": windows, "without_truth": 0,
                   "not_evaluable": 0, "ended": 5, "interrupted": 0, "repeated": 0, "invalid": 0},
        "dropped": {"imu_not_finite": 0, "imu_out_of_order": 3, "imu_glitches": 4, "frames_not_finite": 0,
                    "frames_out_of_order": 0, "observations_not_finite": 0,
                    "observations_duplicate_id": 0, "lines_degenerate": 0},
        "methods": {}}
    summary.update(info)
    with open(os.path.join(folder, "summary.json"), "w", encoding="utf-8") as file:
        json.dump(summary, file)
    return folder
