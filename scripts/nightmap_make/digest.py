# SPDX-License-Identifier: Apache-2.0
"""A text that stands for a longer one in names of files."""

try:  # hashlib loads OpenSSL: a twelfth of the time of a make that finds nothing to do
    from _sha256 import sha256
except ImportError:  # another Python than 3.11
    from hashlib import sha256


def digest(text):
    """64 hexadecimal digits; surrogates stand for bytes of names that are no UTF-8."""
    return sha256(text.encode("utf-8", "surrogatepass")).hexdigest()
