using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("Sweepstake.Editor")]
[assembly: InternalsVisibleTo("Sweepstake.Daemon.Tests")]
[assembly: InternalsVisibleTo("Sweepstake.Unity.Tests")]
