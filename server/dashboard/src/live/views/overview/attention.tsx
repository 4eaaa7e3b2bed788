// The list of problems that need a person.
import { computed } from '@preact/signals';
import { useRef } from 'preact/hooks';
import { counted, grouped, significant } from '../../../format';
import { SessionState as Link } from '../../../gen/sweepstake/v1/sessions_pb';
import { Mode, SwitchReason, Verdict } from '../../../gen/sweepstake/v1/telemetry_pb';
import { mean } from '../../numbers/beta';
import { costNsOf, LOG_COST_REWARD_VERSION } from '../../numbers/log_cost';
import { visible } from '../../parts/name';
import { useEntered } from '../../parts/table';
import { checks, checksError } from '../../state/health';
import { sceneHref, sessionHref } from '../../state/route';
import { connectedSessions, sessions, type SessionState } from '../../state/sessions';
import { type SceneSummary, summaries } from '../../state/summaries';
import { urlOf } from '../../transport/base';

interface Concern {
  text: string;
  places: readonly { href: string; name: string; note?: string }[];
  isBad: boolean;
  allHref?: string; // URL of a view that lists all places
}

const MAX_PLACES = 3; // links per problem
const LATELY_MS = 600_000; // older bail-outs are not listed

const ofScene = ({ state }: SceneSummary) => ({ href: sceneHref(state.posterior), name: state.posterior.scene });

/** Returns what choosing the leader is expected to cost per frame more than the best algorithm, in microseconds; undefined if that is not known. */
function lossUs({ state: { posterior } }: SceneSummary): number | undefined {
  const leader = posterior.arms.find(({ arm, isOutdated }) => arm === posterior.leaderArm && !isOutdated)?.posterior;
  if (!leader || posterior.rewardVersion !== LOG_COST_REWARD_VERSION) return undefined;
  return posterior.expectedLossRatio * costNsOf(mean(leader)) / 1000;
}

/** Returns the ambiguous scenes, those with the highest loss over all sessions first. */
function ambiguous(): Concern | undefined {
  const weight = (row: SceneSummary) => (lossUs(row) ?? 0) * Math.max(1, row.state.posterior.activeSessionCount);
  const found = summaries.value.filter(({ verdict }) => verdict === Verdict.AMBIGUOUS).sort((a, b) => weight(b) - weight(a));
  const all = concern(found, 'scene has no clear best algorithm yet', 'scenes have no clear best algorithm yet', false, urlOf('/?verdict=ambiguous'));
  const places = found.slice(0, MAX_PLACES).map((row) => {
    const us = lossUs(row);
    return { ...ofScene(row), ...(us !== undefined && { note: `${significant(us, 2)} µs per frame` }) };
  });
  return all && { ...all, places: [...places, ...all.places.slice(MAX_PLACES)] };
}

const ofSession = ({ info }: SessionState) => ({ href: sessionHref(info.sessionId), name: `${info.scene} (${info.sessionId.slice(0, 8)})` });

function concern(found: readonly (SceneSummary | SessionState)[], one: string, many: string, isBad: boolean, allHref?: string): Concern | undefined {
  if (found.length === 0) return undefined;
  return { text: counted(found.length, one, many), isBad, ...(allHref && { allHref }), places: found.map((each) => ('state' in each ? ofScene(each) : ofSession(each))) };
}

const bailsOut = ({ state }: SceneSummary) =>
  state.decisions.slice(-50).some(({ reason, unixMs }) => reason === SwitchReason.BAIL_OUT && Date.now() - Number(unixMs) < LATELY_MS);

// Computed again at least whenever the checks are read (state/health.ts), so old bail-outs disappear.
const concerns = computed((): Concern[] => {
  const all = summaries.value;
  const online = connectedSessions.value;
  const lost = [...sessions.value.values()].filter(({ info, ended }) => !ended && info.state === Link.LOST);
  const failed = (checks.value ?? []).filter(({ isOk, note }) => !isOk || note !== '');
  const unknown: Concern[] = checksError.value ? [{ text: `The daemon's checks cannot be read: ${checksError.value.message}`, isBad: true, places: [{ href: urlOf('/health'), name: 'health' }] }] : [];
  return [
    ...unknown,
    ...failed.map(({ name, isOk, note }): Concern => ({ text: `${name}: ${note || 'failed'}`, isBad: !isOk, places: [{ href: urlOf('/health'), name: 'health' }] })),
    concern(all.filter(({ verdict }) => verdict === Verdict.DEGRADED), 'scene is below the frame-rate floor', 'scenes are below the frame-rate floor',
      true, urlOf('/?verdict=degraded')),
    concern(all.filter(bailsOut), 'scene had a bail-out in the last 10 minutes', 'scenes had bail-outs in the last 10 minutes', true),
    ambiguous(),
    concern(lost, 'session has lost the connection to its game', 'sessions have lost the connection to their games', false),
    concern(online.filter(({ info }) => info.droppedFrameCount > 0n), 'game has dropped measurements', 'games have dropped measurements', false),
    concern(online.filter(({ info }) => info.mode === Mode.MANUAL), 'session is in manual mode and adds no evidence',
      'sessions are in manual mode and add no evidence', false),
  ].filter((each) => each !== undefined);
});

/** The number of serious problems. */
export const badCount = computed(() => concerns.value.filter(({ isBad }) => isBad).length);

function Item({ text, places, isBad, allHref }: Concern) {
  const rest = places.length - MAX_PLACES;
  return (
    <li class={isBad ? 'bad' : 'warn'}>
      <span aria-hidden="true">{isBad ? '▲ ' : '△ '}</span>{text}:{' '}
      {places.slice(0, MAX_PLACES).map(({ href, name, note }, i) => <span key={href}>{i > 0 && ', '}<a href={href}><bdi>{visible(name)}</bdi></a>{note && ` (${note})`}</span>)}
      {rest > 0 && <> and {allHref ? <a href={allHref}>{grouped(rest)} more</a> : `${grouped(rest)} more`}</>}
    </li>
  );
}

// The list of problems. It has a fixed size, and does not change while the pointer or the focus is in it.
export function Attention() {
  const { isEntered, handlers } = useEntered();
  const latest = concerns.value;
  const shown = useRef(latest);
  if (!isEntered) shown.current = latest;
  return (
    <section class="attention" aria-labelledby="attention-heading" {...handlers}>
      <h2 id="attention-heading">Needs attention</h2>
      {shown.current.length === 0 ? <p class="soft">Nothing.</p> : <ul>{shown.current.map((each) => <Item key={each.text} {...each} />)}</ul>}
    </section>
  );
}
