#nullable enable
using System;

namespace Sweepstake
{
    /// <summary>How a native call ended.</summary>
    public enum ResultCode
    {
        Ok = 0,
        /// <summary>A value of the caller is wrong.</summary>
        InvalidArgument = 1,
        /// <summary>No such file, name or proxy.</summary>
        NotFound = 2,
        /// <summary>A file exists and its content is broken.</summary>
        DataLoss = 3,
        /// <summary>Could not reach something; trying again may help.</summary>
        Unavailable = 4,
        /// <summary>A buffer is too small, a bound was hit, or memory is out.</summary>
        ResourceExhausted = 5,
        /// <summary>Calls in the wrong order.</summary>
        FailedPrecondition = 6,
        /// <summary>A bug of the library.</summary>
        Internal = 7,
    }

    /// <summary>A native call failed; the message says what to do.</summary>
    public class SweepstakeException : Exception
    {
        public SweepstakeException(ResultCode code, string message, Exception? inner = null)
            : base(message, inner)
        {
            Code = code;
        }

        public ResultCode Code { get; }
    }

    /// <summary>The native library is missing, of another ABI, or not made for this platform.</summary>
    public sealed class NativeLibraryException : SweepstakeException
    {
        public NativeLibraryException(string problem, string remedy, Exception? inner = null)
            : base(ResultCode.Unavailable, problem + " " + remedy, inner)
        {
            Problem = problem;
            Remedy = remedy;
        }

        /// <summary>What is wrong, as a sentence.</summary>
        public string Problem { get; }
        /// <summary>What to do, as a sentence.</summary>
        public string Remedy { get; }
    }
}
