# The built packages on a bare Debian 12: first the command alone, which brings no ROS, then one after the other, each tried by its
# test of debian/tests/. `make try-deb` runs these steps.
FROM debian:bookworm
COPY . /root/battery-sof
COPY *.deb /root/
WORKDIR /root/battery-sof
RUN apt-get update
RUN apt-get install -y --no-install-recommends /root/libbattery-sof0.3_*.deb /root/battery-sof_*.deb
RUN debian/tests/command && ! dpkg-query -W -f='${Package}\n' | grep -E '^(lib|python3-)?ros'
RUN apt-get install -y --no-install-recommends /root/python3-battery-sof_*.deb && debian/tests/python
RUN apt-get install -y --no-install-recommends /root/libbattery-sof-dev_*.deb cmake g++ make pkg-config && debian/tests/library
RUN apt-get install -y /root/ros-battery-sof_*.deb /root/libbattery-sof-msgs-dev_*.deb && debian/tests/node
