#nullable enable
using System;

namespace Sweepstake.Unity
{
    /// <summary>A session with whatever decides for it: made from a config, and changed while the game runs. Main thread.</summary>
    internal sealed class SessionHost : IDisposable
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
            EndWork();
            Decider = new EmbeddedDecider(Session, config.ToDeciderOptions(sceneName));
        }

        /// <summary>From now on a daemon decides. If the connection cannot even be made, the game decides itself.</summary>
        internal void DecideThere(ITelemetryTransport transport, LinkOptions options)
        {
            EndWork();
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
            csv = new FrameCsvWriter(path, Session, scene, seed);
        }

        internal void StopCsv()
        {
            csv?.Dispose();
            csv = null;
        }

        /// <summary>May be called again, and after <see cref="SweepstakeLibrary.Shutdown"/>.</summary>
        public void Dispose()
        {
            StopCsv();
            EndWork();
            Session.Dispose();
        }

        private void EndWork()
        {
            Decider?.Dispose();
            Decider = null;
            Connection?.Dispose();
            Connection = null;
        }
    }
}
