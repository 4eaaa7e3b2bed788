// The list of problems that need attention, each with links to its scenes or sessions.
import { useEffect, useRef } from 'preact/hooks';
import { SessionState as Link } from '../../gen/sweepstake/v1/sessions_pb';
import { Mode, SwitchReason, Verdict } from '../../gen/sweepstake/v1/telemetry_pb';
import { counted, grouped } from '../../format';
import { checks, followChecks } from '../state/health';
import { sceneHref, sessionHref } from '../state/route';
import { connectedSessions, sessions, type SessionState } from '../state/sessions';
import { summaries, type SceneSummary } from '../state/summaries';
import { now } from '../parts/clock';
import { useEntered } from '../parts/entered';
import { visible } from '../parts/visible';

interface Concern {
  text: string;
  places: readonly { href: string; name: string }[];
  isBad: boolean;
  allHref?: string; // a view that lists all of them
}

const MAX_PLACES = 3; // links per problem
const LATELY_MS = 600_000; // older bail-outs are not listed

const ofScene = ({ state }: SceneSummary) => ({ href: sceneHref(state.posterior), name: state.posterior.scene });
const ofSession = ({ info }: SessionState) => ({ href: sessionHref(info.sessionId), name: `${info.scene} (${info.sessionId.slice(0, 8)})` });

function concern(found: readonly (SceneSummary | SessionState)[], one: string, many: string, isBad: boolean, allHref?: string): Concern | undefined {
  if (found.length === 0) return undefined;
  return { text: counted(found.length, one, many), isBad, ...(allHref && { allHref }), places: found.map((each) => ('state' in each ? ofScene(each) : ofSession(each))) };
}

const bailsOut = ({ state }: SceneSummary) =>
  state.decisions.slice(-50).some(({ reason, unixMs }) => reason === SwitchReason.BAIL_OUT && now.value - Number(unixMs) < LATELY_MS);

function concerns(): Concern[] {
  const all = summaries.value;
  const online = connectedSessions.value;
  const lost = [...sessions.value.values()].filter(({ info, ended }) => !ended && info.state === Link.LOST);
  const failed = (checks.value ?? []).filter(({ isOk, note }) => !isOk || note !== '');
  return [
    ...failed.map(({ name, isOk, note }): Concern => ({ text: `${name}: ${note || 'failed'}`, isBad: !isOk, places: [{ href: '/health', name: 'health' }] })),
    concern(all.filter(({ verdict }) => verdict === Verdict.DEGRADED), 'scene misses the frame-rate floor with every arm',
      'scenes miss the frame-rate floor with every arm', true, '/?verdict=degraded'),
    concern(all.filter(bailsOut), 'scene had a bail-out in the last 10 minutes', 'scenes had bail-outs in the last 10 minutes', true),
    concern(lost, 'session has lost the connection to its game', 'sessions have lost the connection to their games', false),
    concern(online.filter(({ info }) => info.droppedFrameCount > 0n), 'game has dropped measurements', 'games have dropped measurements', false),
    concern(online.filter(({ info }) => info.mode === Mode.MANUAL), 'session is in manual mode and adds no evidence',
      'sessions are in manual mode and add no evidence', false),
  ].filter((each) => each !== undefined);
}

function Item({ text, places, isBad, allHref }: Concern) {
  const rest = places.length - MAX_PLACES;
  return (
    <li class={isBad ? 'bad' : 'warn'}>
      <span aria-hidden="true">{isBad ? '▲ ' : '△ '}</span>{text}:{' '}
      {places.slice(0, MAX_PLACES).map(({ href, name }, i) => <span key={href}>{i > 0 && ', '}<a href={href}><bdi>{visible(name)}</bdi></a></span>)}
      {rest > 0 && <> and {allHref ? <a href={allHref}>{grouped(rest)} more</a> : `${grouped(rest)} more`}</>}
    </li>
  );
}

// The list has a fixed size, and does not change while the pointer or the focus is in it.
export function Attention() {
  useEffect(followChecks, []);
  const { isEntered, handlers } = useEntered();
  const latest = concerns();
  const shown = useRef(latest);
  if (!isEntered) shown.current = latest;
  return (
    <section class="attention" aria-labelledby="attention-heading" {...handlers}>
      <h2 id="attention-heading">Needs attention</h2>
      {shown.current.length === 0 ? <p class="soft">Nothing.</p> : <ul>{shown.current.map((each) => <Item key={each.text} {...each} />)}</ul>}
    </section>
  );
}
