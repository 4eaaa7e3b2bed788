[assembly: System.Runtime.CompilerServices.InternalsVisibleTo("Sweepstake.Editor")]
[assembly: System.Runtime.CompilerServices.InternalsVisibleTo("Sweepstake.Daemon.Tests")]
[assembly: System.Runtime.CompilerServices.InternalsVisibleTo("Sweepstake.Unity.Tests")]
