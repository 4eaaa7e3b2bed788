#nullable enable
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>A session with whatever decides for it: made from a config, and changed while the game runs. Main thread.</summary>
    internal sealed class SessionHost
    {
        private readonly SweepstakeConfig config;
        private readonly string sceneName;
        private FrameCsvWriter? csv;

        internal SessionHost(SweepstakeConfig config, SessionMode mode, string backend, string sceneName)
        {
            this.config = config;
            this.sceneName = sceneName;
            Session = new BroadPhaseSession(config.ToSessionOptions(mode, backend));
        }

        internal BroadPhaseSession Session { get; }
        internal EmbeddedDecider? Decider { get; private set; }
        internal DaemonConnection? Connection { get; private set; }

        /// <summary>From now on the game decides itself.</summary>
        internal void DecideHere()
        {
            EndWork(SessionWork.DisposeTimeoutMs);
            Decider = new EmbeddedDecider(Session, config.ToDeciderOptions(sceneName, Application.version));
        }

        /// <summary>From now on a daemon decides. If the connection cannot even be made, the game decides itself.</summary>
        internal void DecideThere(ITelemetryTransport transport, LinkOptions options)
        {
            EndWork(SessionWork.DisposeTimeoutMs);
            try
            {
                Connection = new DaemonConnection(Session, transport, options);
            }
            catch (SweepstakeException)
            {
                DecideHere();
                throw;
            }
        }

        internal void EndFrame(ulong frameTimeNs, FrameFlags flags)
        {
            Session.EndFrame(frameTimeNs, flags);
            csv?.Write(Session.LastSample);
        }

        internal void StartCsv(string path, string scene, ulong seed)
        {
            StopCsv();
            csv = new FrameCsvWriter(path, Session, scene, seed, QualitySettings.vSyncCount);
        }

        internal void StopCsv()
        {
            csv?.Dispose();
            csv = null;
        }

        /// <summary>Lets the CSV file be written to its end, without waiting for it.</summary>
        internal void BeginEnd() => csv?.Stop(0);

        /// <summary>Is over by then, on <see cref="SteadyClock"/>, or at once after <see cref="SweepstakeLibrary.Shutdown"/>.</summary>
        internal void End(ulong endNs)
        {
            BeginEnd();
            EndWork(MsUntil(endNs));
            csv?.Stop(MsUntil(endNs));
            csv = null;
            Session.Dispose();
        }

        /// <summary>When an end that begins now is over.</summary>
        internal static ulong DeadlineNs() => SteadyClock.NowNs + (ulong)SessionWork.DisposeTimeoutMs * 1_000_000;

        private static int MsUntil(ulong endNs)
        {
            ulong nowNs = SteadyClock.NowNs;
            return nowNs < endNs ? (int)((endNs - nowNs) / 1_000_000) : 0;
        }

        private void EndWork(int timeoutMs)
        {
            Decider?.Stop(timeoutMs);
            Decider = null;
            Connection?.Stop(timeoutMs);
            Connection = null;
        }
    }
}
