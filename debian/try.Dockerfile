# The built packages on a bare Debian 12, to the first answers: of the command, then of the node. `make try-deb` runs these steps.
FROM debian:bookworm
COPY battery-sof_*.deb /root/
RUN apt-get update
RUN apt-get install -y /root/battery-sof_*.deb
RUN sof demo /root/drive.bag && sof identify /root/drive.bag --out /root/model.yaml && sof crank /root/model.yaml --i-load -20 --t-stop 30 --i-cranking -200 --u-required 7.2
RUN python3 -c 'import battery_sof; print(battery_sof.crank(battery_sof.Model.read("/root/model.yaml"), i_load=-20, t_stop=30, i_cranking=-200))'
RUN roslaunch battery_sof replay.launch bag:=/root/drive.bag rate:=20 >/root/node.log 2>&1 & node=$!; for attempt in $(seq 100); do rosservice call /battery_sof_node/predict_cranking '{i_load: -20, t_stop: 30, i_cranking: -200}' 2>/dev/null | tee /root/answer | grep -q 'valid: True' && break; sleep 0.3; done; cat /root/answer; kill $node; wait $node; grep -q 'valid: True' /root/answer
