"""How far long work is and how long it will still take, on standard error: a bar where that is a terminal, else a line now and then."""

import sys

try:
    from tqdm import tqdm
except ImportError:  # python3-tqdm is not installed
    tqdm = None

EVERY = 10  # of the items, where there is no bar


def followed(items, what, total=None):
    """The items, with progress. `total` where they have no length."""
    total = len(items) if total is None else total
    has_terminal = sys.stderr.isatty()
    if has_terminal and tqdm:
        yield from tqdm(items, desc=what, total=total, dynamic_ncols=True)
        return
    for k, item in enumerate(items, 1):
        yield item
        if has_terminal or k % EVERY == 0 or k == total:
            print(f"{what} {k} of {total}", file=sys.stderr, flush=True)
