"""run.py FILE CLASS: runs one class of command-line tests for ctest.

Ends with 0 where all passed, 77 (skipped) where every test skipped itself, else 1. A class
without tests fails: nothing may look tested that is not.
"""

import importlib.util
import pathlib
import sys
import unittest

SKIPPED = 77


def main(file, name):
    path = pathlib.Path(file).resolve()
    sys.path.insert(0, str(path.parent))
    sys.dont_write_bytecode = True
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    spec.loader.exec_module(module)

    suite = unittest.defaultTestLoader.loadTestsFromTestCase(getattr(module, name))
    result = unittest.TextTestRunner(verbosity=2).run(suite)
    if not suite.countTestCases():
        print(f"{path.name}: {name} holds no tests", file=sys.stderr)
        return 1
    if not result.wasSuccessful():
        return 1
    return SKIPPED if len(result.skipped) >= result.testsRun else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
