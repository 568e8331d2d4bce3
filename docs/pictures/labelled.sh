#!/bin/sh
# Makes the pictures of docs/deflection.md from the panels that deflection_pictures.cpp draws: labelled.sh PANELS OUT
set -e
panels=$1 out=$2 label=$(dirname "$0")/labelled.py
python3 "$label" "$out/deflection_shift.png" 2 \
  "none. The head turned by 6° to the side, 2° up and 4° about its line of sight since the picture was drawn=$panels/turn_none.png" \
  "shift. Right at the centre, wrong towards the edges, and not turned=$panels/turn_shift.png" \
  "shift_roll. Turned in its plane too=$panels/turn_shift_roll.png" \
  "rotation. All of it fits, near and far=$panels/turn_rotation.png"
python3 "$label" "$out/deflection_depth.png" 2 \
  "rotation. The head stepped 4 cm aside and turned by 3°: the turn is corrected, but the nearer a thing, the more it is left behind=$panels/step_rotation.png" \
  "plane. At 1 m: what stands there fits, the rest does not=$panels/step_plane.png" \
  "depth. Everything that was seen fits, near and far=$panels/step_depth.png" \
  "depth, its mask. Red was hidden when the picture was drawn: its colour is a guess=$panels/step_mask.png"
python3 "$label" "$out/deflection_rolling.png" 2 \
  "rotation, all lines at once. The head turns at 300°/s; real upright edges lean, the virtual ones do not=$panels/rolling_at_once.png" \
  "rotation, line by line. Each line has the pose of its own moment=$panels/rolling_by_line.png"
