// The daemon's health: its checks, and figures that show problems early.
import { useEffect } from 'preact/hooks';
import { bytes, grouped, mean, significant } from '../../format';
import { Chip } from '../parts/chips';
import { duration, now, timeText } from '../parts/clock';
import { CopyLink } from '../parts/toast';
import { Sparkline } from '../parts/sparkline';
import { Failure, Loading } from '../parts/states';
import { account } from '../state/account';
import { checks, followHealth, healthError, labelOf, learnChecks, learnFigures, type Metrics, quantileOf, type Sample, samples, sumOf,
  valueOf } from '../state/health';

const WINDOW = 30;  // number of samples for rates and quantiles: one minute

interface Row {
  name: string;
  value: string;
  curve?: readonly number[];
  isBad?: boolean;
  hint?: string;
}

type Reader = (metrics: Metrics) => number | undefined;
const readerOf = (figure: string | Reader): Reader => (typeof figure === 'string' ? (metrics) => valueOf(metrics, figure) : figure);
const shown = (value: number | undefined, text: (value: number) => string) => (value === undefined ? '–' : text(value));

// Returns the growth of a counter per second between consecutive samples.
function ratesOf(all: readonly Sample[], read: Reader): number[] {
  return all.slice(1).map(({ atMs, metrics }, i) => {
    const before = all[i]!;
    const grown = (read(metrics) ?? 0) - (read(before.metrics) ?? 0);
    return Math.max(0, grown) / Math.max(0.001, (atMs - before.atMs) / 1000);
  });
}

function gauge(name: string, all: readonly Sample[], figure: string | Reader, text = grouped, more: Partial<Row> = {}): Row {
  const curve = all.map(({ metrics }) => readerOf(figure)(metrics)).filter((value) => value !== undefined);
  return { name, value: shown(curve.at(-1), text), curve, ...more };
}

const perSecond = (value: number) => `${significant(value)} /s`;

function rate(name: string, all: readonly Sample[], figure: string, text = perSecond): Row {
  const curve = ratesOf(all, readerOf(figure));
  return { name, value: shown(curve.length ? mean(curve.slice(-WINDOW)) : undefined, text), curve };
}

function seconds(value: number | undefined): string {
  if (value === undefined) return '–';
  if (value === Infinity) return '> 10 s';
  return value < 1 ? `≤ ${significant(value * 1000, 2)} ms` : `≤ ${significant(value, 2)} s`;
}

function latency(name: string, all: readonly Sample[], histogram: string, hint: string): Row {
  const last = all.at(-1)!.metrics;
  const before = all.at(-1 - WINDOW)?.metrics;
  const at = (share: number) => quantileOf(last, before, histogram, share);
  return { name, hint, value: `p50 ${seconds(at(0.5))}, p99 ${seconds(at(0.99))}`, isBad: (at(0.99) ?? 0) >= 1 };
}

const groupsOf = (all: readonly Sample[]): readonly { heading: string; rows: readonly Row[]; empty?: string }[] => [
  { heading: 'Decision loop', rows: [
    latency('Lateness', all, 'sweepstake_decision_loop_lateness_seconds', 'How late the loop ran its timers: median and 99th percentile of the last minute'),
    rate('Decisions', all, 'sweepstake_decisions_total'),
    rate('Switch commands', all, 'sweepstake_switch_commands_total'),
    gauge('Refused switches', all, 'sweepstake_refused_switches_total', grouped, { hint: 'Switch commands that a game did not execute, since the start of the daemon' }),
  ] },
  { heading: 'Games and watchers', rows: [
    gauge('Streams of games', all, 'sweepstake_open_streams'),
    gauge('Sessions in memory', all, 'sweepstake_sessions'),
    gauge('Watchers', all, 'sweepstake_open_watchers'),
    rate('Messages', all, 'sweepstake_applied_messages_total'),
    rate('Frames', all, 'sweepstake_accepted_frames_total'),
    rate('Visits of the shadow lane', all, 'sweepstake_accepted_shadow_samples_total'),
    gauge('Frames that games dropped', all, 'sweepstake_dropped_frames_total', grouped, { hint: 'Since the start of the daemon: frames that did not fit into the queue of a game' }),
    gauge('Resumed sessions', all, 'sweepstake_resumed_sessions_total'),
  ] },
  { heading: 'Store', rows: storeRows(all) },
  { heading: 'Process', rows: processRows(all) },
  { heading: 'Refused since the start', rows: refusalRows(all), empty: 'Nothing was refused.' },
];

function storeRows(all: readonly Sample[]): Row[] {
  const { metrics } = all.at(-1)!;
  const most = valueOf(metrics, 'sweepstake_store_max_size_bytes') ?? 0;
  const used = valueOf(metrics, 'sweepstake_store_used_size_bytes') ?? 0;
  const isHealthy = valueOf(metrics, 'sweepstake_store_healthy') !== 0;
  const isDamaged = (valueOf(metrics, 'sweepstake_store_damaged') ?? 0) > 0;
  const backupS = valueOf(metrics, 'sweepstake_store_last_backup_timestamp_seconds') ?? 0;
  const lostRows = valueOf(metrics, 'sweepstake_lost_audit_rows_total') ?? 0;
  const state = !isHealthy ? 'cannot read or write' : isDamaged ? 'has lost evidence' : 'works';
  return [
    { name: 'State', value: state, isBad: !isHealthy || isDamaged },
    gauge('Space in use', all, 'sweepstake_store_used_size_bytes', (value) => (most ? `${bytes(value)} of ${bytes(most)}` : bytes(value)),
      { isBad: most > 0 && used > 0.9 * most }),
    gauge('Size of the file', all, 'sweepstake_store_size_bytes', bytes),
    gauge('Write-ahead log', all, 'sweepstake_store_wal_size_bytes', bytes),
    gauge('Queued updates', all, 'sweepstake_store_queued_commits'),
    gauge('Queued reads', all, 'sweepstake_store_queued_reads'),
    latency('Commit', all, 'sweepstake_store_commit_duration_seconds', 'How long a group of updates took: median and 99th percentile of the last minute'),
    latency('Sync', all, 'sweepstake_store_fsync_duration_seconds', 'How long fsync took: median and 99th percentile of the last minute'),
    gauge('Audit log not yet written', all, 'sweepstake_waiting_audit_bytes', bytes),
    { name: 'Lost audit rows', value: grouped(lostRows), isBad: lostRows > 0 },
    { name: 'Last backup', value: backupS ? `${duration(now.value - backupS * 1000)} ago` : 'none', ...(backupS && { hint: timeText(backupS * 1000) }) },
  ];
}

function processRows(all: readonly Sample[]): Row[] {
  const { metrics } = all.at(-1)!;
  const started = valueOf(metrics, 'process_start_time_seconds');
  const expires = valueOf(metrics, 'sweepstake_tls_certificate_expiry_timestamp_seconds');
  return [
    { name: 'Version', value: account.value?.version || labelOf([...metrics.get('sweepstake_build_info')?.keys() ?? []][0] ?? '', 'version') || '–' },
    { name: 'Uptime', value: started ? duration(now.value - started * 1000) : '–' },
    rate('Processor', all, 'process_cpu_seconds_total', (cores) => `${significant(100 * cores, 2)} % of a core`),
    gauge('Memory', all, 'process_resident_memory_bytes', bytes),
    gauge('Open files', all, 'process_open_fds', (value) => `${grouped(value)} of ${grouped(valueOf(metrics, 'process_max_fds') ?? NaN)}`),
    ...(expires ? [{ name: 'TLS certificate expires', value: timeText(expires * 1000), isBad: expires * 1000 < now.value }] : []),
  ];
}

// Refusals and failures: calls, frames and lane visits by reason, the rest as totals. Counts of 0 are left out.
function refusalRows(all: readonly Sample[]): Row[] {
  const { metrics } = all.at(-1)!;
  const byReason = (family: string, what: string) => [...metrics.get(family) ?? []].filter(([, value]) => value > 0)
    .map(([labels]): Row => gauge(`${what}: ${labelOf(labels, 'reason')}`, all, (each) => each.get(family)?.get(labels)));
  const total = (name: string, what: string) => (sumOf(metrics, name) > 0 ? [gauge(what, all, name)] : []);
  return [
    ...byReason('sweepstake_errors_total', 'Failed calls'),
    ...byReason('sweepstake_rejected_frames_total', 'Frames rejected'),
    ...byReason('sweepstake_rejected_shadow_samples_total', 'Visits rejected'),
    ...total('sweepstake_malformed_messages_total', 'Malformed messages'),
    ...total('sweepstake_invalid_messages_total', 'Invalid messages'),
    ...total('sweepstake_replayed_messages_total', 'Messages sent twice'),
    ...total('sweepstake_surplus_bail_outs_total', 'Surplus bail-outs'),
    ...total('sweepstake_refused_connections_total', 'Refused connections'),
    ...total('sweepstake_unread_calls_total', 'Calls ended unread'),
    ...total('sweepstake_failed_commits_total', 'Failed commits'),
    ...total('sweepstake_degraded_starts_total', 'Starts without evidence'),
  ];
}

// Replaces the space between a number and its unit, so that no line breaks there.
const glued = (text: string) => text.replaceAll(/(?<=[\d≤>]) (?=[\dA-Za-z/%])/g, '\u00a0');

function Rows({ heading, rows, empty }: { heading: string; rows: readonly Row[]; empty?: string }) {
  return (
    <section class="card">
      <h2>{heading}</h2>
      {rows.length === 0 ? <p class="soft">{empty}</p> : (
        <table class="figures-table">
          <caption class="unseen">{heading}</caption>
          <tbody>
            {rows.map(({ name, value, curve, isBad, hint }) => (
              <tr key={name} class={isBad ? 'bad' : undefined} title={hint}>
                <th scope="row">{name}</th>
                <td>{isBad && <span aria-hidden="true">▲ </span>}{glued(value)}</td>
                <td class="curve">{curve && curve.length > 1 && <Sparkline values={curve} low={0} />}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
    </section>
  );
}

function Checks() {
  const all = checks.value;
  if (!all) return <Loading what="the checks" />;
  return (
    <ul class="checks">
      {all.map(({ name, isOk, note }) => (
        <li key={name}>
          <Chip tone={isOk ? (note ? 'warn' : 'good') : 'bad'} sign={isOk ? '✓' : '✗'}>{name}</Chip>
          <span>{note || (isOk ? 'ok' : 'failed')}</span>
        </li>
      ))}
    </ul>
  );
}

export function Health() {
  useEffect(followHealth, []);
  const all = samples.value;
  const error = healthError.value;
  return (
    <>
      <header class="title"><h1>Health of the daemon</h1><CopyLink /></header>
      {error && <Failure what="The current health" error={error} onRetry={() => { void learnChecks(); void learnFigures(); }} />}
      {(checks.value || !error) && <section class="card"><h2>Ready to serve</h2><Checks /></section>}
      {all.length === 0 ? !error && <Loading what="the figures" /> : (
        <div class="cards">{groupsOf(all).map((group) => <Rows key={group.heading} {...group} />)}</div>
      )}
    </>
  );
}
