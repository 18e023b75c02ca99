// The live page: one connection, a tab a battery. What is shown of the battery that is chosen is drawn at most four times a second.
(function () {
  'use strict';

  const KEPT = 4000, ROWS = 12;
  const batteries = [];
  let chosen = 0, changed = true, held = false, span = 120;
  const graphs = {};

  const el = (id) => document.getElementById(id);
  const color = (name) => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
  const isNumber = (value) => typeof value === 'number';
  const fixed = (value, digits) => isNumber(value) ? value.toFixed(digits) : value === 'inf' ? '∞' : '–';
  const percent = (value) => isNumber(value) ? (100 * value).toFixed(0) + ' %' : '–';

  // Seconds of a recording as they are; of a clock that counts from 1970 the time of day.
  function time(seconds) {
    if (!isNumber(seconds)) return '–';
    return seconds > 1e8 ? new Date(1e3 * seconds).toLocaleTimeString() : seconds.toFixed(1) + ' s';
  }

  function duration(seconds) {
    if (!isNumber(seconds)) return fixed(seconds);
    return seconds < 120 ? seconds.toFixed(seconds < 10 ? 1 : 0) + ' s' : seconds < 7200 ? (seconds / 60).toFixed(0) + ' min' : (seconds / 3600).toFixed(1) + ' h';
  }

  function make(tag, attributes, ...children) {
    const node = tag in { svg: 1, rect: 1, line: 1 } ? document.createElementNS('http://www.w3.org/2000/svg', tag) : document.createElement(tag);
    Object.entries(attributes || {}).forEach(([name, value]) => node.setAttribute(name, value));
    node.append(...children);
    return node;
  }

  // ---------------------------------------------------------------------------------------------- what comes in
  function empty(name) {
    return { name: name, bins: [], expected: [], answers: [], cranks: [], charges: [], status: null, diagnosis: null };
  }

  // Rows that are later than those there are; the beginning may come twice.
  function append(list, rows, at) {
    rows.forEach((row) => { if (!list.length || at(row) > at(list[list.length - 1])) list.push(row); });
    if (list.length > KEPT) list.splice(0, list.length - KEPT);
  }

  function take(news) {
    if (news.batteries) {
      if (news.batteries.join() !== batteries.map((one) => one.name).join()) {
        batteries.splice(0, batteries.length, ...news.batteries.map(empty));
        chosen = Math.min(chosen, batteries.length - 1);
        makeTabs();
      }
      return;
    }
    if (news.forget) batteries[news.battery] = empty(batteries[news.battery].name);
    const battery = batteries[news.battery];
    append(battery.bins, news.bins || [], (row) => row[0]);
    append(battery.expected, news.expected || [], (row) => row[0]);
    append(battery.answers, news.answers || [], (row) => row[0]);
    append(battery.cranks, news.cranks || [], (event) => event.time);
    append(battery.charges, news.charges || [], (event) => event.time);
    if (news.status) battery.status = news.status;
    if (news.diagnosis) battery.diagnosis = news.diagnosis;
    if (news.battery === chosen || news.status) changed = true;
  }

  function say(text, lost) {
    const line = el('connection');
    if (line.textContent !== text) line.textContent = text;
    line.classList.toggle('lost', Boolean(lost));
  }

  function connect(wait) {
    const socket = new WebSocket('ws://' + location.host + '/news');
    socket.onopen = () => { say('connected'); wait = 500; };
    socket.onmessage = (event) => take(JSON.parse(event.data));
    socket.onclose = () => {
      say('connection lost: what is shown is old', true);
      setTimeout(() => connect(Math.min(2 * wait, 8000)), wait);
    };
  }

  // ---------------------------------------------------------------------------------------------- tabs
  function makeTabs() {
    const list = el('tabs');
    list.hidden = batteries.length < 2;
    list.replaceChildren(...batteries.map((battery, k) => {
      const tab = make('button', { type: 'button', role: 'tab', id: 'tab-' + k, 'aria-controls': 'panel' }, battery.name);
      tab.addEventListener('click', () => choose(k));
      return tab;
    }));
    choose(chosen);
  }

  function choose(k, focus) {
    chosen = k;
    [...el('tabs').children].forEach((tab, n) => {
      tab.setAttribute('aria-selected', n === k);
      tab.tabIndex = n === k ? 0 : -1;
      if (n === k && focus) tab.focus();
    });
    if (batteries.length > 1) el('panel').setAttribute('aria-labelledby', 'tab-' + k);
    changed = true;
    draw(true);
  }

  function onKey(event) {
    const last = batteries.length - 1;
    const to = { ArrowRight: chosen === last ? 0 : chosen + 1, ArrowLeft: chosen === 0 ? last : chosen - 1, Home: 0, End: last }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    choose(to, true);
  }

  // ---------------------------------------------------------------------------------------------- model and answers
  // A text is touched only where it changes: a screen reader reads a change aloud.
  function text(id, value) {
    if (el(id).textContent !== value) el(id).textContent = value;
  }

  function showState(status) {
    text('state', status ? status.state : 'no data');
    el('state').className = 'badge ' + (status ? status.state === 'ready' ? 'ready' : '' : '');
    text('reason', status && status.state !== 'ready' ? status.reason : '');
    if (!status) return el('figures').replaceChildren();
    const rows = [['Answers rest on', { population: 'lead-acid batteries in general', previous_trip: 'the previous trip', this_trip: 'this trip' }[status.answer_basis] || '–'], ['Model age', duration(status.model_age)], ['Window quality', fixed(status.window_quality, 2)],
      ['Voltage explained', isNumber(status.backtest_q_dyn_percent) ? status.backtest_q_dyn_percent.toFixed(1) + ' %' : '–'],
      ['Further physics', status.effects.join(', ') || 'none'], ['Driven by', status.voltage_controlled ? 'voltage' : 'current'],
      ['Samples', status.accepted + (status.rejected ? ' (' + status.rejected + ' refused)' : '')]];
    el('figures').replaceChildren(...rows.map(([name, value]) => make('div', {}, make('dt', {}, name), make('dd', {}, value))));
  }

  // Interval, answer and limit on one scale.
  function bar(answer, low, high) {
    const x = (value) => (100 * Math.min(Math.max(((value === 'inf' ? high : value) - low) / (high - low), 0), 1)).toFixed(2) + '%';
    const width = parseFloat(x(answer.upper)) - parseFloat(x(answer.lower));
    const parts = [make('line', { x1: '0', x2: '100%', y1: '50%', y2: '50%', stroke: color('line') }),
      make('rect', { x: x(answer.lower), width: Math.max(width, .5) + '%', y: '20%', height: '60%', fill: color('bar') }),
      make('line', { x1: x(answer.value), x2: x(answer.value), y1: '10%', y2: '90%', stroke: color('expected'), 'stroke-width': 3 })];
    if (isNumber(answer.limit)) parts.push(make('line', { x1: x(answer.limit), x2: x(answer.limit), y1: '0', y2: '100%', stroke: color('bad'), 'stroke-width': 2, 'stroke-dasharray': '4 3' }));
    return make('svg', { role: 'img', 'aria-label': answer.spoken }, ...parts);
  }

  // The word that an answer's message begins with; none where no limit was given, or where there is no answer.
  const word = (message) => (/^(holds|not assured|not valid): /.exec(message) || ['', ''])[1];

  function card(answer, low, high) {
    const is_there = isNumber(answer.value) || answer.value === 'inf';
    const said = is_there ? word(answer.message) : '';
    const box = make('article', { class: 'answer ' + ({ holds: 'holds', 'not assured': 'fails' }[said] || '') }, make('h3', {}, answer.title),
      make('span', { class: 'value' }, is_there ? answer.shown : '–'), ' ', make('span', { class: 'word' }, said));
    if (is_there) box.append(bar(answer, low, high), make('p', {}, answer.spoken));
    if (!is_there || !answer.valid) box.append(make('p', {}, answer.message));
    return box;
  }

  function crankAnswer(s) {
    const a = s.crank;
    return { title: 'Crank after ' + duration(s.t_stop) + ' off: lowest voltage', value: a.u_min, lower: a.lower, upper: a.upper, limit: s.u_required, valid: a.valid,
      shown: fixed(a.u_min, 2) + ' V', message: a.message,
      spoken: fixed(a.lower, 2) + ' to ' + fixed(a.upper, 2) + ' V; ' + (isNumber(s.u_required) ? 'needed ' + fixed(s.u_required, 2) + ' V' : 'no limit') + ' at ' + fixed(s.i_cranking, 0) + ' A' };
  }

  function stopAnswer(s) {
    const a = s.stop_time;
    return { title: 'Longest stop before such a crank', value: a.t_stop, lower: a.lower, upper: a.upper, limit: s.t_stop, valid: a.valid, message: a.message,
      shown: (a.outcome === 'at_least' ? 'at least ' : '') + duration(a.t_stop), spoken: duration(a.lower) + ' to ' + duration(a.upper) + '; asked for ' + duration(s.t_stop) + ' at ' + fixed(s.i_load, 0) + ' A' };
  }

  function chargeAnswer(s) {
    const a = s.charge;
    return { title: 'Mean charge current at ' + fixed(s.u_boost, 1) + ' V for ' + duration(s.t_sof2), value: a.i_boost, lower: a.lower, upper: a.upper, valid: a.valid,
      shown: fixed(a.i_boost, 1) + ' A', message: a.message, spoken: fixed(a.lower, 1) + ' to ' + fixed(a.upper, 1) + ' A' };
  }

  function showAnswers(status) {
    if (!status) return el('answers').replaceChildren(make('p', {}, 'None without a model.'));
    const stop = stopAnswer(status), charge = chargeAnswer(status);
    const longest = Math.max(...[stop.value, stop.limit].filter(isNumber), 60) * 1.5;
    el('answers').replaceChildren(card(crankAnswer(status), isNumber(status.u_required) ? Math.min(6, status.u_required - .5) : 6, 13), card(stop, 0, longest),
      card(charge, Math.min(0, isNumber(charge.lower) ? charge.lower : 0), Math.max(isNumber(charge.upper) ? 1.2 * charge.upper : 0, 50)));
  }

  // ---------------------------------------------------------------------------------------------- plots
  function legend(data) {
    const parts = data.series.map((series) => '<span><i style="border-color:' + series.color + '"></i>' + series.labelHTML +
      (data.x === undefined || series.y === undefined || series.y === null ? '' : ' ' + series.yHTML) + '</span>');
    return (data.x === undefined ? '' : '<span>' + time(data.x) + '</span>') + parts.join('');
  }

  function makeGraph(id, labels, colors, options) {
    return new Dygraph(el(id), [[0].concat(labels.map(() => [null, null, null]))], Object.assign({ labels: ['time'].concat(labels), customBars: true, colors: colors.map(color),
      labelsDiv: el(id + '-legend'), legend: 'always', legendFormatter: legend, fillAlpha: .35, axisLineColor: color('line'), gridLineColor: color('line'), interactionModel: {},
      connectSeparatedPoints: true, axes: { x: { valueFormatter: time, axisLabelFormatter: (value) => time(value).replace(/\.0 s/, ' s'), pixelsPerLabel: 90 }, y: { axisLabelWidth: 46 } } }, options));
  }

  // A crank's answer with its interval.
  function whisker(graph, name, canvas, x, y, stroke, size, row) {
    const value = graph.getValue(row, 3);
    canvas.fillStyle = canvas.strokeStyle = stroke;
    canvas.lineWidth = 2;
    canvas.beginPath();
    canvas.moveTo(x, graph.toDomYCoord(value[0]));
    canvas.lineTo(x, graph.toDomYCoord(value[2]));
    canvas.stroke();
    canvas.beginPath();
    canvas.arc(x, y, size, 0, 2 * Math.PI);
    canvas.fill();
  }

  function makeGraphs() {
    graphs.voltage = makeGraph('voltage', ['measured', 'expected', 'crank expected'], ['measured', 'expected', 'crank'],
      { series: { expected: { strokeWidth: 0, drawPoints: true, pointSize: 2 }, 'crank expected': { strokeWidth: 0, connectSeparatedPoints: false, drawPoints: true, pointSize: 5, drawPointCallback: whisker } } });
    graphs.current = makeGraph('current', ['measured'], ['measured'], {});
    graphs.answer = makeGraph('answer', ['lowest voltage of the next crank'], ['expected'], {});
  }

  function showPlots(battery) {
    const none = [null, null, null];
    const newest = battery.bins.length ? battery.bins[battery.bins.length - 1][0] : 0;
    const from = span ? newest - span : -Infinity;
    const bins = battery.bins.filter((b) => b[0] >= from);
    if (!bins.length) bins.push([0, null, null, null, null]);
    const range = (low, high) => [low, low === null ? null : .5 * (low + high), high];
    const rows = bins.map((b) => [b[0], range(b[1], b[2]), none, none])
      .concat(battery.expected.filter((e) => e[0] >= from).map((e) => [e[0], none, [e[1], e[1], e[1]], none]))
      .concat(battery.cranks.filter((c) => c.time >= from && isNumber(c.expected)).map((c) => [c.time, none, none, [c.lower, c.expected, c.upper]]));
    rows.sort((a, b) => a[0] - b[0]);
    const window_ = span ? [newest - span, newest] : null;
    graphs.voltage.updateOptions({ file: rows, dateWindow: window_ });
    graphs.current.updateOptions({ file: bins.map((b) => [b[0], range(b[3], b[4])]), dateWindow: window_ });
    const answers = battery.answers.filter((row) => row[0] >= from);
    if (!answers.length) answers.push([0, null, null, null]);
    graphs.answer.updateOptions({ file: answers.map((row) => [row[0], row.slice(1)]), dateWindow: window_ });
    const last = battery.bins[battery.bins.length - 1], expected = battery.expected[battery.expected.length - 1];
    el('voltage').setAttribute('aria-label', 'Voltage over time; last measured ' + fixed(last && last[1], 2) + ' V, last expected ' + fixed(expected && expected[1], 2) + ' V');
    const answer = answers[answers.length - 1];
    el('answer').setAttribute('aria-label', 'Answer to the next crank over time; now ' + fixed(answer[2], 2) + ' V, 90 % between ' + fixed(answer[1], 2) + ' and ' + fixed(answer[3], 2) + ' V');
    el('current').setAttribute('aria-label', 'Current over time; last measured ' + fixed(last && last[3], 1) + ' A');
  }

  // ---------------------------------------------------------------------------------------------- past, diagnosis
  function showPast(id, events, unit, digits, title, share) {
    const rows = events.slice(-ROWS).reverse().map((event) => {
      const inside = event.measured >= event.lower && event.measured <= event.upper;
      return make('tr', {}, make('th', { scope: 'row' }, time(event.time)), make('td', {}, fixed(event.measured, digits)), make('td', {}, fixed(event.expected, digits)),
        make('td', {}, fixed(event.lower, digits) + ' to ' + fixed(event.upper, digits)), make('td', inside ? {} : { class: 'outside' }, inside ? 'inside' : 'outside'));
    });
    const head = ['time', 'measured', 'expected', '90 %', ''].map((name) => make('th', { scope: 'col' }, name));
    if (!rows.length) rows.push(make('tr', {}, make('td', { colspan: 5 }, 'none yet')));
    el(id).replaceChildren(make('caption', {}, title + ' [' + unit + ']; ' + share), make('thead', {}, make('tr', {}, ...head)), make('tbody', {}, ...rows));
  }

  function showDiagnosis(diagnosis) {
    const key = JSON.stringify(diagnosis);
    if (el('diagnosis').dataset.shown === key) return;
    el('diagnosis').dataset.shown = key;
    if (!diagnosis) return el('diagnosis').replaceChildren(make('p', {}, 'None yet.'));
    const parts = [make('p', {}, make('span', { class: 'badge ' + diagnosis.verdict }, diagnosis.verdict.replace(/_/g, ' ')), ' ', diagnosis.summary)];
    if (diagnosis.effects.length) parts.push(make('p', {}, 'Found: ' + diagnosis.effects.map((e) => e.id + ' (' + percent(e.probability) + ')').join(', ')));
    if (diagnosis.adopted) parts.push(make('p', {}, diagnosis.adoption));
    if (diagnosis.next_experiment) parts.push(make('p', { class: 'note' }, 'To record next: ' + diagnosis.next_experiment));
    el('diagnosis').replaceChildren(...parts);
  }

  function draw(now) {
    if (!batteries.length || (!changed && !now)) return;
    changed = false;
    const battery = batteries[chosen], status = battery.status;
    showState(status);
    showAnswers(status);
    showPast('cranks', battery.cranks, 'V', 3, 'Lowest voltage of cranks', percent(status && status.past_cranks.coverage) + ' inside, mean error ' + fixed(status && status.past_cranks.mean_abs_error, 3) + ' V');
    showPast('charges', battery.charges, 'A', 1, 'Mean current of charges', percent(status && status.past_charges.coverage) + ' inside, mean error ' + fixed(status && status.past_charges.mean_abs_error, 1) + ' A');
    showDiagnosis(battery.diagnosis);
    [...el('tabs').children].forEach((tab, k) => tab.classList.toggle('ailing', Boolean(batteries[k].status && batteries[k].status.state === 'ready' && word(batteries[k].status.crank.message).startsWith('not'))));
    if (!held || now) showPlots(battery);
  }

  el('tabs').addEventListener('keydown', onKey);
  el('span').addEventListener('change', (event) => { span = Number(event.target.value); draw(true); });
  el('hold').addEventListener('click', (event) => { held = !held; event.target.setAttribute('aria-pressed', held); });
  if (typeof Dygraph === 'undefined') {
    say('the plot library is missing: install libjs-dygraphs', true);
  } else {
    makeGraphs();
    window.livePage = { batteries: batteries, graphs: graphs };
    setInterval(draw, 250);
    connect(500);
  }
})();
