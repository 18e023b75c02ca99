// The plots of a diagnosis page: three graphs of one drive that zoom together. Needs Dygraph and #drive-data.
(function () {
  'use strict';

  const source = document.getElementById('drive-data');
  if (!source || typeof Dygraph === 'undefined') return;
  const drive = JSON.parse(source.textContent);
  const models = ['base', 'extended'].filter((name) => drive[name]);
  const whole = [drive.time[0], drive.time[drive.time.length - 1]];
  const graphs = [];
  let busy = false;

  const color = (name) => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
  const rows = (columns) => drive.time.map((t, n) => [t].concat(columns.map((column) => column(n))));
  const error = (model) => (n) =>
    drive.measured[n] === null || drive[model][n] === null ? null : 1e3 * (drive.measured[n] - drive[model][n]);

  function shade(canvas, area, graph) {
    const band = (from, to, name) => {
      const left = graph.toDomXCoord(from), right = graph.toDomXCoord(to);
      canvas.fillStyle = color(name);
      canvas.fillRect(left, area.y, Math.max(right - left, 1), area.h);
    };
    canvas.lineJoin = 'round';
    if (drive.holdout) band(drive.holdout[0], drive.holdout[1], 'shade-holdout');
    drive.mismatch.forEach((stretch) => band(stretch[0], stretch[1], 'shade-mismatch'));
  }

  // Hatched, with a solid foot: told from the other shades without colour, and seen where it is short.
  function shadeImposed(canvas, area, graph) {
    shade(canvas, area, graph);
    const tile = document.createElement('canvas');
    tile.width = tile.height = 8;
    const pen = tile.getContext('2d');
    pen.strokeStyle = color('controlled');
    pen.beginPath();
    [-4, 4, 12].forEach((x) => { pen.moveTo(x - 6, 10); pen.lineTo(x + 6, -2); });
    pen.stroke();
    const hatch = canvas.createPattern(tile, 'repeat');
    drive.controlled.forEach((stretch) => {
      const left = Math.max(graph.toDomXCoord(stretch[0]), area.x);
      const width = Math.min(graph.toDomXCoord(stretch[1]), area.x + area.w) - left;
      if (width <= 0) return;
      canvas.fillStyle = hatch;
      canvas.fillRect(left, area.y, width, area.h);
      canvas.fillStyle = color('controlled-foot');
      canvas.fillRect(left, area.y + area.h - 5, width, 5);
    });
  }

  function colors(names) {
    return { colors: names.map(color), axisLineColor: color('line'), gridLineColor: color('line'),
      rangeSelectorPlotStrokeColor: color('current'), rangeSelectorPlotFillColor: color('line'),
      rangeSelectorForegroundStrokeColor: color('soft'), rangeSelectorBackgroundStrokeColor: color('line') };
  }

  function legend(data) {
    const shown = data.series.filter((series) => series.isVisible).map((series) => {
      const value = data.x === undefined || series.y === undefined || series.y === null ? '' : ' ' + series.yHTML;
      return '<span><i style="border-color:' + series.color + '"></i>' + series.labelHTML + value + '</span>';
    });
    const time = data.x === undefined ? '' : '<span>' + data.xHTML + ' s</span>';
    return time + shown.join('');
  }

  // What one graph shows, all show; a graph that is no longer zoomed frees the others too.
  function follow(graph) {
    if (busy) return;
    busy = true;
    const range = graph.xAxisRange();
    const all = !graph.isZoomed('x');
    graphs.forEach((other) => {
      if (other === graph) return;
      const same = other.xAxisRange().every((value, k) => value === range[k]);
      if (!same) other.updateOptions({ dateWindow: all ? null : range.slice() });
      if (all && !graph.isZoomed('y') && other.isZoomed('y')) other.updateOptions({ valueRange: null });
    });
    busy = false;
  }

  function point(graph, row) {
    graphs.forEach((other) => {
      if (other === graph) return;
      if (row === null) other.clearSelection();
      else other.setSelection(row);
    });
  }

  // One finger scrolls the page, two zoom.
  function interaction() {
    const usual = Dygraph.defaultInteractionModel;
    return Object.assign({}, usual, {
      touchstart: (event, graph, context) => event.touches.length > 1 && usual.touchstart(event, graph, context),
      touchmove: (event, graph, context) => event.touches.length > 1 && usual.touchmove(event, graph, context),
    });
  }

  function plot(id, series, digits, options) {
    const div = document.getElementById(id);
    if (!div) return;
    const names = series.map((s) => s.name);
    const styles = {};
    series.forEach((s) => { styles[s.name] = { strokeWidth: s.width || 1.3 }; });
    const graph = new Dygraph(div, rows(series.map((s) => s.at)), Object.assign({
      labels: ['time'].concat(names), labelsDiv: id + '-legend', legend: 'always', legendFormatter: legend,
      series: styles, interactionModel: interaction(), underlayCallback: shade, drawCallback: follow,
      highlightCallback: (event, x, points, row) => point(graph, row), unhighlightCallback: () => point(graph, null),
      digitsAfterDecimal: digits, axes: { y: { axisLabelWidth: 44 }, x: { pixelsPerLabel: 70 } },
      highlightCircleSize: 3, connectSeparatedPoints: false, xRangePad: 0,
    }, colors(series.map((s) => s.color || s.name)), options));
    graph.ofColors = series.map((s) => s.color || s.name);
    graphs.push(graph);
  }

  const column = (name) => (n) => drive[name][n];
  plot('plot-voltage', [{ name: 'measured', at: column('measured'), width: 2.6 }].concat(
    models.map((name) => ({ name: name, at: column(name) }))), 3, { underlayCallback: shadeImposed });
  plot('plot-error', models.map((name) => ({ name: name, at: error(name) })), 1, {});
  plot('plot-current', [{ name: 'current', at: column('current') }], 1,
    { showRangeSelector: true, rangeSelectorHeight: 32, rangeSelectorPlotLineWidth: 1 });

  function zoom(from, to) {
    if (!graphs.length) return;
    const room = 0.15 * (to - from);
    const window_ = [Math.max(from - room, whole[0]), Math.min(to + room, whole[1])];
    graphs[0].updateOptions({ dateWindow: window_ });
  }

  // The stretch after the middle of what is shown; the first one when all is shown, and after the last.
  function next(stretches, least) {
    const range = graphs[0].xAxisRange();
    const middle = graphs[0].isZoomed('x') ? 0.5 * (range[0] + range[1]) : -Infinity;
    const found = stretches.find((s) => s[0] > middle) || stretches[0];
    const spare = 0.5 * Math.max(least - (found[1] - found[0]), 0);
    zoom(found[0] - spare, found[1] + spare);
  }

  function onClick(id, action) {
    const button = document.getElementById(id);
    if (button) button.addEventListener('click', action);
  }
  onClick('zoom-all', () => graphs.forEach((graph) => graph.updateOptions({ dateWindow: null, valueRange: null })));
  onClick('zoom-holdout', () => zoom(drive.holdout[0], drive.holdout[1]));
  onClick('zoom-mismatch', () => next(drive.mismatch, 0));
  onClick('zoom-crank', () => next(drive.cranks, 4));
  document.querySelectorAll('button.show').forEach((button) => button.addEventListener('click', () => {
    zoom(Number(button.dataset.from), Number(button.dataset.to));
    document.getElementById('drive').scrollIntoView({ behavior: 'smooth' });
  }));

  const repaint = () => graphs.forEach((graph) => graph.updateOptions(colors(graph.ofColors)));
  window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', repaint);
  window.addEventListener('beforeprint', () => graphs.forEach((graph) => graph.resize(660, graph.height_)));
  window.addEventListener('afterprint', () => graphs.forEach((graph) => graph.resize()));
  window.diagnosisPlots = graphs;
})();
