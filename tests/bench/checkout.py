# SPDX-License-Identifier: Apache-2.0
"""Where the checkout is. Imported first by each benchmark: it makes the packages of scripts/ importable."""

import sys
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[2]
if str(CHECKOUT / "scripts") not in sys.path:
    sys.path.insert(0, str(CHECKOUT / "scripts"))
