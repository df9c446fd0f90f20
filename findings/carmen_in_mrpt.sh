#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# carmen2rawlog of MRPT 2.5.8 (Debian 12: mrpt-apps 1:2.5.8+ds-2) takes every beam of a FLASER line for half a degree. CARMEN's logs of a
# SICK state no angles: 180 and 181 beams are 1 degree apart, 360 and 361 half a degree, and all cover the half circle in front. The
# converter gives 90 and 90.5 degrees of view to the former, without a message, so such a log (the one of the Intel Research Lab is one)
# makes a building of half its angles. 361 beams get 180.5 degrees. The field of view is the number after the class name in the rawlog.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
libraries=$(printf 'libmrpt-%s2.5=1:2.5.8+ds-2 ' bayes config containers core expr img io math obs opengl poses random rtti serialization system tfest)
# shellcheck disable=SC2086
apt-get download -qq mrpt-apps=1:2.5.8+ds-2 $libraries libassimp5 libsimpleini1 libfyaml0 libdraco7 >/dev/null 2>&1
for package in *.deb; do dpkg -x "$package" root; done
program=$(find root -name carmen2rawlog -type f)
folder_of_libraries=$(dirname "$(find root -name libmrpt-obs.so.2.5)")
cat >view.py <<'PY'
import gzip, math, struct, sys
data = open(sys.argv[1], "rb").read()
data = gzip.decompress(data) if data[:2] == b"\x1f\x8b" else data
name = b"CObservation2DRangeScan"
at = data.index(name) + len(name) + 1
print(f"{math.degrees(struct.unpack('<f', data[at : at + 4])[0]):.1f}")
PY
for beams in 180 181 360 361; do
  { printf 'FLASER %d' "$beams"; for ((i = 0; i < beams; ++i)); do printf ' 5.00'; done; echo ' 0 0 0 0 0 0 1.0 host 1.0'; } >in.log
  LD_LIBRARY_PATH=$folder_of_libraries "$program" -w -q -i in.log -o out.rawlog >/dev/null
  echo "$beams beams: $(python3 view.py out.rawlog) deg"
done >seen
cat seen
cat >expected <<'TXT'
180 beams: 90.0 deg
181 beams: 90.5 deg
360 beams: 180.0 deg
361 beams: 180.5 deg
TXT
cmp seen expected
