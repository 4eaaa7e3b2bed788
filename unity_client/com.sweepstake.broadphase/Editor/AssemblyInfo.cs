[assembly: System.Runtime.CompilerServices.InternalsVisibleTo("Sweepstake.Unity.Tests")]
[assembly: System.Runtime.CompilerServices.InternalsVisibleTo("Sweepstake.Editor.Tests")]
