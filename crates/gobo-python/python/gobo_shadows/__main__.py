"""``python -m gobo_shadows``: the program ``gobo``."""

import sys

from . import main

sys.exit(main())
