"""The part of pyproject.toml that is code: the version is that of package.xml, and CMake builds what is compiled.

CMAKE_ARGS in the environment has further arguments for CMake, and CMAKE_BUILD_PARALLEL_LEVEL how many jobs it starts."""
import glob
import os
import re
import shlex
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

SOURCE = os.path.dirname(os.path.abspath(__file__))
BUILD = os.path.join(SOURCE, "build_wheel")  # beside build, which is another package's


class BuildByCMake(build_ext):
    def run(self):
        options = ["-DBATTERY_SOF_ROS=OFF", "-DBATTERY_SOF_PYTHON=ON", "-DBUILD_TESTING=OFF", "-DBUILD_SHARED_LIBS=OFF",
                   f"-DPython3_EXECUTABLE={sys.executable}", *shlex.split(os.environ.get("CMAKE_ARGS", ""))]
        subprocess.check_call(["cmake", "-S", SOURCE, "-B", BUILD, *options])
        jobs = [] if "CMAKE_BUILD_PARALLEL_LEVEL" in os.environ else [f"-j{os.cpu_count()}"]
        subprocess.check_call(["cmake", "--build", BUILD, "--target", "battery_sof_python", "sof", *jobs])
        package = os.path.join(self.build_lib, "battery_sof")
        os.makedirs(package, exist_ok=True)
        for file in glob.glob(os.path.join(BUILD, "python", "battery_sof", "_core*.so")) + [os.path.join(BUILD, "sof")]:
            shutil.copy(file, package)


with open(os.path.join(SOURCE, "package.xml"), encoding="utf-8") as file:
    version = re.search("<version>(.*)</version>", file.read())[1]
os.makedirs(BUILD, exist_ok=True)
setup(version=version, packages=["battery_sof"], package_dir={"battery_sof": "python/battery_sof"},
      package_data={"battery_sof": ["py.typed", "*.pyi"]}, ext_modules=[Extension("battery_sof._core", [])],
      cmdclass={"build_ext": BuildByCMake},
      options={"build": {"build_base": os.path.join(BUILD, "setuptools")}, "egg_info": {"egg_base": BUILD}})
