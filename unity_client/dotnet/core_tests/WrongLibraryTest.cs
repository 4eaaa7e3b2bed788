#nullable disable
using System;
using System.Diagnostics;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Runtime.InteropServices;
using System.Runtime.Loader;
using NUnit.Framework;

namespace Sweepstake.Tests
{
    /// <summary>Tests that a missing library, or a library with another ABI, gives an error that says what to do.</summary>
    public sealed class WrongLibraryTest
    {
        private string folder;

        [SetUp]
        public void MakeFolder()
        {
            folder = Directory.CreateTempSubdirectory("sweepstake").FullName;
        }

        [TearDown]
        public void RemoveFolder()
        {
            Directory.Delete(folder, true);
        }

        [Test]
        public void AMissingLibrarySaysWhereItBelongs()
        {
            AssertProblem(() => throw new DllNotFoundException("no such file"), "'sweepstake' was not found", "Runtime/Plugins");
        }

        [Test]
        public void ALibraryOfAnotherAbiIsNotUsed()
        {
            AssertProblem(() => Compiled("unsigned swp_abi_version(void) { return 2; }"), "has ABI 2, and this package needs ABI 3", "Runtime/Plugins");
        }

        [Test]
        public void ALibraryWithOtherStructsIsNotUsed()
        {
            AssertProblem(
                () => Compiled("unsigned swp_abi_version(void) { return 3; } unsigned swp_struct_size(unsigned which) { return which == 7 ? 60 : 400; }"),
                "FrameSample has 64 bytes in C#, 64 in the C headers and 60 in the library", "Runtime/Plugins");
        }

        [Test]
        public void AnotherLibraryOfTheNameIsNotUsed()
        {
            AssertProblem(() => Compiled("int something_else(void) { return 0; }"), "lacks a function that this package needs", "Runtime/Plugins");
        }

        /// <summary>An iOS build without the archive: an import of a function that does not exist would break its link.</summary>
        [Test]
        public void ABuildWithoutALibraryImportsNothingAndSaysThatThePlatformIsNotSupported()
        {
            Assembly core = Assembly.Load("Sweepstake.Core.Ios");
            Type functions = core.GetType(typeof(LowLevel.NativeMethods).FullName!)!;
            MethodInfo[] declared = functions.GetMethods(BindingFlags.Static | BindingFlags.Public | BindingFlags.DeclaredOnly);
            Assert.That(declared, Has.Length.EqualTo(typeof(LowLevel.NativeMethods).GetMethods(BindingFlags.Static | BindingFlags.Public | BindingFlags.DeclaredOnly).Length));
            foreach (MethodInfo function in core.GetTypes().SelectMany(type => type.GetMethods(BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.DeclaredOnly)))
                Assert.That(function.Attributes & MethodAttributes.PinvokeImpl, Is.EqualTo(default(MethodAttributes)), function.Name);
            Assert.That(Thrown(functions.GetMethod("swp_abi_version")), Is.InstanceOf<NotSupportedException>());

            Exception told = Thrown(core.GetType(typeof(SweepstakeLibrary).FullName!)!.GetMethod(nameof(SweepstakeLibrary.EnsureLoaded)));
            Assert.That(told.Message, Does.Contain("does not support this platform").And.Contain("SWEEPSTAKE_IOS"));
            Assert.That(told.InnerException, Is.InstanceOf<NotSupportedException>());
        }

        private static Exception Thrown(MethodInfo function) => Assert.Throws<TargetInvocationException>(() => function.Invoke(null, null))!.InnerException;

        private IntPtr Compiled(string source)
        {
            string code = Path.Combine(folder, "fake.c");
            string library = Path.Combine(folder, "libfake.so");
            File.WriteAllText(code, source);
            using Process compiler = Process.Start("cc", new[] { "-shared", "-fPIC", "-o", library, code });
            compiler!.WaitForExit();
            Assert.That(compiler.ExitCode, Is.EqualTo(0));
            return NativeLibrary.Load(library);
        }

        /// <summary>
        /// Loads the package again, with the library that `load` returns, and checks the problem that the package reports.
        /// </summary>
        private static void AssertProblem(Func<IntPtr> load, string problem, string remedy)
        {
            var domain = new AssemblyLoadContext("wrong library", isCollectible: true);
            Assembly core = domain.LoadFromAssemblyPath(typeof(SweepstakeLibrary).Assembly.Location);
            NativeLibrary.SetDllImportResolver(core, (name, assembly, path) => load());
            Type library = core.GetType(typeof(SweepstakeLibrary).FullName!)!;
            var found = (Exception)library.GetMethod(nameof(SweepstakeLibrary.FindProblem))!.Invoke(null, null);
            Assert.That(found, Is.Not.Null);
            Assert.That(found!.Message, Does.Contain(problem).And.Contain(remedy));
            var thrown = Assert.Throws<TargetInvocationException>(
                () => library.GetMethod(nameof(SweepstakeLibrary.EnsureLoaded))!.Invoke(null, null));
            Assert.That(thrown!.InnerException!.Message, Is.EqualTo(found.Message));
            Assert.That(library.GetMethod(nameof(SweepstakeLibrary.Shutdown))!.Invoke(null, new object[] { 10 }), Is.True, "there is nothing to end");
            domain.Unload();
        }
    }
}
