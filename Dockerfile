# Debian 12 with its own ROS 1 packages and this checkout, built.
#     docker build -t battery_sof .
#     docker run --rm --network host battery_sof roslaunch battery_sof battery_sof.launch
#     docker run --rm -v "$PWD":/data -w /data battery_sof sof check drive.bag
# scripts/try_dockerfile runs its steps in a fresh root file system.
FROM debian:bookworm
COPY scripts/install_dependencies /opt/battery_sof/scripts/install_dependencies
RUN apt-get update && apt-get install -y --no-install-recommends make ca-certificates && bash /opt/battery_sof/scripts/install_dependencies build && rm -rf /var/lib/apt/lists/*
COPY . /opt/battery_sof
WORKDIR /opt/battery_sof
RUN make build
RUN build/devel/env.sh sof demo /tmp/drive.bag && build/devel/env.sh sof check /tmp/drive.bag && rm /tmp/drive.bag
ENTRYPOINT ["/opt/battery_sof/build/devel/env.sh"]
CMD ["roslaunch", "battery_sof", "battery_sof.launch"]
