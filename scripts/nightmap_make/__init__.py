# SPDX-License-Identifier: Apache-2.0
"""How make runs the declared pipeline: the declaration, a site's rules, the check before a run and the summary after."""
